// make_hostile.c - the files of hostile.h from outside: `make_hostile` lists the kinds; `make_hostile KIND COUNT SEED PATH` writes one
// (COUNT 0: the kind's own).
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/files/hostile.h"

int main(int argc, char **argv) {
    if (argc == 1) {
        for (const HostileKind *kind = HOSTILE_KINDS; kind->name; kind++)
            printf("%s %s %d %s\n", kind->name, kind->suffix, kind->count,
                   kind->may_refuse ? "may-refuse" : "opens");
        return 0;
    }
    const HostileKind *kind = argc == 5 ? hostile_find(argv[1]) : NULL;
    if (!kind) {
        fputs("usage: make_hostile [KIND COUNT SEED PATH]\n", stderr);
        return 2;
    }
    int count = atoi(argv[2]);
    if (hostile_write(kind, count > 0 ? count : kind->count, (uint64_t)atoll(argv[3]), argv[4])) return 0;
    fprintf(stderr, "%s: cannot be written: %s\n", argv[4], strerror(errno));
    return 1;
}
