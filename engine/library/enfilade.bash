# Completion of enfilade for bash. Commands, options and their choices are asked of the program itself.
_enfilade() {
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} program=${COMP_WORDS[0]}
    local command=${COMP_WORDS[1]}
    if [ "$COMP_CWORD" -eq 1 ]; then
        local commands
        commands=$("$program" --help 2>/dev/null | sed -n '/^commands:/,/^$/s/^  \([a-z]*\) .*/\1/p')
        mapfile -t COMPREPLY < <(compgen -W "$commands --help --version" -- "$word")
    elif [[ $word == -* ]]; then
        local options
        options=$("$program" "$command" --help 2>/dev/null | grep -oE '(^|[ [])--?[a-z][a-z-]*' | tr -d ' [')
        mapfile -t COMPREPLY < <(compgen -W "$options --help" -- "$word")
    elif [[ $before == --method || $before == --methods || $before == --hidden || $before == --culling ]]; then
        # Tables of names stand at the end of the help, two blanks before each. A benchmark says whose help it is.
        local names of=$command
        [ "$command" != bench ] || of=$("$program" bench "${COMP_WORDS[2]}" --methods "?" 2>&1 |
            sed -n 's/.*`enfilade \([a-z]*\) --help` lists.*/\1/p')
        [ "$of" != bench ] && [ -n "$of" ] || return 0
        names=$("$program" "$of" --help 2>/dev/null | sed -n 's/^  \([a-z][a-z0-9-]*\)  .*/\1/p')
        mapfile -t COMPREPLY < <(compgen -W "$names" -- "$word")
    elif [ "$command" = bench ] && [ "$COMP_CWORD" -eq 2 ]; then
        local benches
        benches=$("$program" bench --help 2>/dev/null | sed -n 's/^  \([a-z]*\)  .*/\1/p')
        mapfile -t COMPREPLY < <(compgen -W "$benches" -- "$word")
    else
        compopt -o filenames 2>/dev/null
        mapfile -t COMPREPLY < <(compgen -f -- "$word")
    fi
}
complete -F _enfilade enfilade
