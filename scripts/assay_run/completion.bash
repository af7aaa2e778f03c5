# SPDX-License-Identifier: Apache-2.0
# Bash completion of assay-run and assay-scene.
_assay_run() {
    local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} key= i
    local settings="@ASSAY_SETTINGS@" # the build writes each KEY=VALUE here
    for ((i = 1; i < COMP_CWORD; i++)); do
        if [ "${COMP_WORDS[i]}" = -- ]; then
            # shellcheck disable=SC2207
            [ $((i + 1)) = "$COMP_CWORD" ] && COMPREPLY=($(compgen -A command -A file -- "$word")) ||
                COMPREPLY=($(compgen -f -- "$word"))
            return
        fi
    done
    # Bash splits a word at =.
    case $previous$word in
    *=) key=$previous word= ;;
    =*) key=${COMP_WORDS[COMP_CWORD - 2]} ;;
    --level* | --backend*) key=${previous#--} ;;
    esac
    if [ -n "$key" ]; then
        mapfile -t COMPREPLY < <(compgen -W "$settings" -- "$key=$word")
        COMPREPLY=("${COMPREPLY[@]#*=}")
        return
    fi
    case $previous in
    --set) mapfile -t COMPREPLY < <(compgen -W "$settings" -- "$word") ;;
    --junit | --sarif | --json | --html | --scene | --baseline | --write-baseline | --merge)
        mapfile -t COMPREPLY < <(compgen -f -- "$word")
        ;;
    --record | --capture) mapfile -t COMPREPLY < <(compgen -d -- "$word") ;;
    --error-exitcode) ;;
    *)
        mapfile -t COMPREPLY < <(compgen -W "--level --backend --everything --set --lavapipe --with-khronos --count-khronos
            --stop-at-first --live --no-live --junit
            --sarif --json --html --github --record --capture --scene --quiet --error-exitcode --baseline
            --strict-baseline --advice-is-error --write-baseline --merge --help --" -- "$word")
        ;;
    esac
}
complete -o filenames -F _assay_run assay-run

_assay_scene() {
    local word=${COMP_WORDS[COMP_CWORD]} words=
    case ${COMP_WORDS[1]} in
    info) words="--json --all" ;;
    export) words="--at --tlas --color --plain-nodes" ;;
    view) words="--limit" ;;
    replay) words="--layer --compare --time --repeat --dump" ;;
    minimize) words="--finding" ;;
    report) words="--html --json --at --tlas --camera --rays --device" ;;
    esac
    case $COMP_CWORD${COMP_WORDS[COMP_CWORD - 1]} in
    1*) words="info export view replay minimize report --help --version" ;;
    *--at) words="frame: submission: build: label:" ;;
    *--color) words="structure flags" ;;
    *) [[ $word = -* ]] || words= ;;
    esac
    if [ -n "$words" ]; then
        mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
    else
        mapfile -t COMPREPLY < <(compgen -f -- "$word")
    fi
}
complete -o filenames -F _assay_scene assay-scene
