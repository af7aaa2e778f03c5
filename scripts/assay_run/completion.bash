# SPDX-License-Identifier: Apache-2.0
# Bash completion of assay-run.
_assay_run() {
    local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} i
    for ((i = 1; i < COMP_CWORD; i++)); do
        if [ "${COMP_WORDS[i]}" = -- ]; then
            # shellcheck disable=SC2207
            [ $((i + 1)) = "$COMP_CWORD" ] && COMPREPLY=($(compgen -A command -A file -- "$word")) ||
                COMPREPLY=($(compgen -f -- "$word"))
            return
        fi
    done
    case $previous in
    --level) mapfile -t COMPREPLY < <(compgen -W "parameters state execution content" -- "$word") ;;
    --backend) mapfile -t COMPREPLY < <(compgen -W "driver cpu" -- "$word") ;;
    --junit | --sarif | --json | --html | --baseline | --write-baseline | --merge)
        mapfile -t COMPREPLY < <(compgen -f -- "$word")
        ;;
    --record) mapfile -t COMPREPLY < <(compgen -d -- "$word") ;;
    --set | --error-exitcode) ;;
    *)
        mapfile -t COMPREPLY < <(compgen -W "--level --backend --everything --set --lavapipe --with-khronos --count-khronos
            --stop-at-first --live --no-live --junit
            --sarif --json --html --github --record --quiet --error-exitcode --baseline
            --strict-baseline --advice-is-error --write-baseline --merge --help --" -- "$word")
        ;;
    esac
}
complete -o filenames -F _assay_run assay-run
