#!/bin/sh
# man.sh PROGRAM - the manual page, from what the program says of itself: it cannot be out of date.
program=$1
version=$("$program" --version | cut -d' ' -f2)

# Text as it is: backslashes doubled, no line taken for a request.
plain() { sed 's/\\/\\e/g; s/^\([.'"'"']\)/\\\&\1/; s/-/\\-/g'; }
verbatim() { printf '.nf\n' && plain && printf '.fi\n'; }

printf '.TH ENFILADE 1 "" "enfilade %s" "User Commands"\n' "$version"
printf '.SH NAME\n'
"$program" --help | head -1 | plain
printf '.SH SYNOPSIS\n.B enfilade\n.I COMMAND\n[\\fIOPTIONS\\fR] ...\n'
printf '.SH DESCRIPTION\n'
"$program" --help | tail -n +3 | verbatim
"$program" --help | sed -n '/^commands:/,/^$/s/^  \([a-z]*\) .*/\1/p' | while read -r command; do
    printf '.SH "ENFILADE %s"\n' "$(echo "$command" | tr a-z A-Z)"
    "$program" "$command" --help | verbatim
done
cat <<'EOF'
.SH FILES
.TP
.I $XDG_CACHE_HOME/enfilade, ~/.cache/enfilade
Stab trees and light, under the hash of the building's file. May be deleted at any time.
.SH ENVIRONMENT
.TP
.B DISPLAY, WAYLAND_DISPLAY
Where the window of \fBenfilade walk\fR opens; without them \fB\-\-offscreen\fR draws.
.SH SEE ALSO
The formats of buildings are described in README.md and PLAN.md beside the sample buildings, in share/enfilade.
EOF
