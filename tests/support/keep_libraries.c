// keep_libraries.c - part of the program in config=asan alone: libraries once loaded stay. The leak sanitizer cannot name one
// that is gone, and lsan.supp is by name: Mesa's driver for windows leaks a little and is unloaded before leaks are looked for.
#include <dlfcn.h>

int dlclose(void *library) {
    (void)library;
    return 0;
}
