# SPDX-License-Identifier: Apache-2.0
# Functions around apt: what is installed, what can be installed, and packages of suites that are not
# among the machine's sources. Such suites are read through sources and lists in a temporary folder, so
# that the machine's apt configuration does not change. Needs common.sh, $log, and os-release's variables.
# shellcheck shell=bash disable=SC2154

as_root() {
    if [ "$(id -u)" = 0 ]; then
        "$@"
    else
        sudo "$@"
    fi
}

require_root() {
    if [ "$(id -u)" != 0 ] && ! command -v sudo >/dev/null; then
        die "must install $*: run as root, or install sudo."
    fi
}

# package_installed NAME: prints the installed version, or fails.
package_installed() {
    local status version
    read -r status version < <(dpkg-query -W -f '${db:Status-Status} ${Version}\n' "$1" 2>/dev/null) ||
        return 1
    [ "$status" = installed ] && printf '%s\n' "$version"
}

# package_candidate NAME: prints the version that the machine's own sources offer, or fails.
package_candidate() {
    apt-cache policy "$1" 2>/dev/null |
        awk '$1 == "Candidate:" && $2 != "(none)" { print $2; found = 1 } END { exit !found }'
}

# version_at_least VERSION MINIMUM: compares by Debian's order; an empty MINIMUM is always met.
version_at_least() {
    [ -z "$2" ] || dpkg --compare-versions "$1" ge "$2"
}

# logged COMMAND...: runs COMMAND with its output in the log, and prints the log's end if it fails.
logged() {
    local line count=0 status=1
    printf '\n$ %s\n' "$*" >>"$log"
    while IFS= read -r line; do
        [[ $line == status=* ]] || printf '%s\n' "$line" >>"$log"
        case $line in
        Get:* | "Setting up "*)
            count=$((count + 1))
            [ $((count % 50)) != 0 ] || say "  ... $count packages downloaded or set up"
            ;;
        status=*) status=${line#status=} ;;
        esac
    done < <("$@" </dev/null 2>&1 && echo status=0 || echo "status=$?")
    if [ "$status" != 0 ]; then
        tail -n 15 "$log" >&2
        return 1
    fi
}

# lists_update: runs once. Some lists may be unreadable and not needed; $lists_state says so.
lists_state=
lists_update() {
    [ -z "$lists_state" ] || return 0
    say "  reading the package lists"
    lists_state=fresh
    logged as_root apt-get update -q -o APT::Update::Error-Mode=any || {
        say "  some package lists could not be read; continuing without them"
        lists_state=incomplete
    }
}

# packages_install [APT OPTION]... PACKAGE...
packages_install() {
    logged as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y \
        --no-install-recommends --no-remove -o DPkg::Lock::Timeout=600 -o Dpkg::Use-Pty=0 "$@"
}

# debian_entry: prints "RELEASE|URI|FILE:NUMBER" of the apt source of this Debian's own archive. Other
# archives may share its codename.
debian_entry() {
    # shellcheck disable=SC2016 # apt fills these in
    apt-get indextargets 'Created-By: Packages' --format \
        '$(ORIGIN)|$(LABEL)|$(CODENAME)|$(COMPONENT)|$(REPO_URI)|$(RELEASE)|$(SOURCESENTRY)' |
        awk -F'|' -v OFS='|' -v codename="$VERSION_CODENAME" '
            $1 == "Debian" && $2 == "Debian" && $3 == codename && $4 == "main" && $5 !~ /^cdrom:/ {
                print $6, $5, $7
                exit
            }'
}

# stanza_for_suite FILE RELEASE URI SUITE: prints the stanza of a .sources file that has RELEASE at URI,
# with SUITE instead; keys and mirrors stay the same.
stanza_for_suite() {
    awk -v release="$2" -v uri="$3" -v suite="$4" '
        function has(list, word,    words, count, i) {
            count = split(list, words, /[ \t\n]+/)
            for (i = 1; i <= count; i++) {
                if (words[i] == word || words[i] "/" == word) return 1
            }
            return 0
        }
        BEGIN { RS = ""; FS = "\n" }
        {
            kept = suites = uris = field = ""
            for (i = 1; i <= NF; i++) {
                if ($i ~ /^#/) continue
                value = $i
                if ($i !~ /^[ \t]/) {
                    field = tolower(substr($i, 1, index($i, ":") - 1))
                    value = substr($i, index($i, ":") + 1)
                }
                if (field == "suites") suites = suites " " value
                if (field == "uris") uris = uris " " value
                if (field !~ /^(types|suites|components|enabled|targets)$/) kept = kept $i "\n"
            }
            if (has(suites, release) && has(uris, uri)) {
                printf "Types: deb\nSuites: %s\nComponents: main\nTargets: Packages\n%s", suite, kept
                exit
            }
        }' "$1"
}

# line_for_suite FILE NUMBER SUITE: the same for a file in the one-line format.
line_for_suite() {
    local line options
    line=$(sed -n "$2p" "$1")
    [[ $line =~ ^[[:space:]]*deb[[:space:]]+(\[([^]]*)\][[:space:]]+)?([^[:space:]]+)[[:space:]] ]] ||
        return 1
    options=${BASH_REMATCH[2]}
    printf 'deb [%s target=Packages] %s %s main\n' "$options" "${BASH_REMATCH[3]}" "$3"
}

# suite_open SUITE [ARCHITECTURE | Sources]: prepares the functions below for SUITE of this Debian's archive.
# Packages of another architecture than the machine's can only be downloaded. With Sources, it prepares
# the source packages instead, for apt-get source with "${suite_only[@]}".
suite_open() {
    local suite=$1 kind=Packages architecture='' entry release uri place
    case ${2:-} in
    Sources) kind=Sources ;;
    *) architecture=${2:-} ;;
    esac
    entry=$(debian_entry)
    if [ -z "$entry" ]; then
        lists_update
        entry=$(debian_entry)
    fi
    [ -n "$entry" ] ||
        die "no entry for Debian's $VERSION_CODENAME, main, among apt's sources to derive $suite from."
    IFS='|' read -r release uri place <<<"$entry"

    suite_folder=$(mktemp -d)
    trap 'rm -rf "$suite_folder"' EXIT
    chmod 755 "$suite_folder"
    mkdir -p "$suite_folder"/{lists/partial,parts,empty,debs}
    local file=${place%:*} number=${place##*:}
    suite_source=$suite_folder/parts/assay-$suite.${file##*.}
    case $file in
    *.sources) stanza_for_suite "$file" "$release" "$uri" "$suite" >"$suite_source" ;;
    *) line_for_suite "$file" "$number" "$suite" >"$suite_source" ;;
    esac
    [ -s "$suite_source" ] || die "cannot derive $suite from $file."
    if [ -n "$architecture" ]; then # the machine's source may be for its own architecture only
        sed -i -e '/^Architectures:/Id' -e 's/\barch=[^] ]*//' "$suite_source"
    fi
    [ "$kind" != Sources ] ||
        sed -i 's/^Types: deb$/Types: deb-src/; s/^Targets: .*/Targets: Sources/; s/^deb /deb-src /; s/target=Packages/target=Sources/' "$suite_source"

    # Only the suite itself is fetched; the machine's own lists are read where they lie.
    local lists
    lists=$(apt-config shell lists Dir::State::lists/f)
    eval "$lists"
    find "$lists" -maxdepth 1 -type f ! -name lock -exec ln -s -t "$suite_folder/lists" {} +
    suite_options=(
        -o "Dir::State::lists=$suite_folder/lists"
        -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache=
        ${architecture:+-o "APT::Architecture=$architecture" -o "APT::Architectures=$architecture"})
    suite_only=(
        "${suite_options[@]}"
        -o "Dir::Etc::sourcelist=$suite_source"
        -o "Dir::Etc::sourceparts=$suite_folder/empty"
        -o Dir::Etc::preferences=/dev/null
        -o "Dir::Etc::preferencesparts=$suite_folder/empty")
    say "  reading the package lists of $suite"
    # Testing's are valid for a week, and a mirror may be older: the signature counts, not the age.
    logged apt-get update -q "${suite_only[@]}" -o APT::Get::List-Cleanup=false \
        -o APT::Update::Error-Mode=any -o Acquire::Check-Valid-Until=false ||
        die "cannot read $suite from the mirror of $VERSION_CODENAME."
}

# suite_install PACKAGE: from the open suite, its dependencies from there only where they must be.
suite_install() {
    local options parts
    parts=$(apt-config shell parts Dir::Etc::sourceparts/d)
    eval "$parts"
    find "$parts" -maxdepth 1 -name '*.list' -o -maxdepth 1 -name '*.sources' |
        while IFS= read -r file; do ln -sf "$file" "$suite_folder/parts/"; done
    options=("${suite_options[@]}" -o "Dir::Etc::sourceparts=$suite_folder/parts")
    apt-get -s install --no-install-recommends --no-remove "${options[@]}" "$1" </dev/null 2>&1 |
        awk -v script="$script" '
            $1 == "Inst" && $3 ~ /^\[/ { gsub(/[][()]/, ""); print script ":   upgrades " $2 " " $3 " to " $4 }'
    packages_install "${options[@]}" "$1"
}

# suite_download PACKAGE...: leaves the .deb files, whose signed checksums apt has verified, in
# $suite_folder/debs.
suite_download() {
    (cd "$suite_folder/debs" && logged apt-get download -q "${suite_only[@]}" "$@")
}

suite_close() {
    rm -rf "$suite_folder"
    trap - EXIT
}
