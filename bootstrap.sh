#!/bin/sh
# Sets up bsm-mesh in .venv beside this file, if that is not done yet, and then runs it:
#
#     sh bootstrap.sh demo            the whole chain on a built-in case
#     sh bootstrap.sh run ARGS...     the same as: .venv/bin/bsm-mesh run ARGS...
#     sh bootstrap.sh test            formatter, linter, types, doctests, tests
#
# What it needs and what it looks at is told in docs/installation.md. Its own words go to standard error,
# so that standard output is the program's.
set -eu

usage() {
    sed -n '2,6s/^# \{0,1\}//p' "$0" >&2
    exit 2
}

say() { printf 'bootstrap: %s\n' "$*" >&2; }

fail() {
    say "$@"
    exit 2
}

root=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
venv=$root/.venv
python=$venv/bin/python

# What the libraries' names are in Debian and its relatives (docs/installation.md says which file needs which).
gmsh_packages="libglu1-mesa libgl1 libgomp1 libxcursor1 libxft2 libxinerama1"
picture_packages="libegl1 libgl1-mesa-dri"

# ---------------------------------------------------------------------------------------- system packages

as_root="" # what stands before a command that needs root; "no" where there is no way
find_root() {
    as_root=no
    if [ -n "${BOOTSTRAP_NO_APT:-}" ] || ! command -v apt-get >/dev/null 2>&1; then
        return
    elif [ "$(id -u)" = 0 ]; then
        as_root=
    elif command -v sudo >/dev/null 2>&1 && sudo -n true >/dev/null 2>&1; then
        as_root="sudo -n"
    fi
}

# apt_install PACKAGE...: installs them, or says what to type and returns 1; a second time, in silence.
apt_refused=""
apt_install() {
    [ -z "$apt_refused" ] || return 1
    find_root
    if [ "$as_root" != no ]; then
        say "installing with apt: $*"
        if $as_root apt-get update -q >&2 && $as_root env DEBIAN_FRONTEND=noninteractive \
            apt-get install -y -q --no-install-recommends -o DPkg::Lock::Timeout=300 "$@" >&2; then
            return 0
        fi
        say "apt did not manage that."
    fi
    apt_refused=yes
    say "system packages are missing. On Debian or Ubuntu type the next line; for others see docs/installation.md."
    printf '\n    sudo apt-get install --no-install-recommends %s\n\n' "$*" >&2
    return 1
}

# ------------------------------------------------------------------------------------------------- Python

is_new_enough() {
    "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1
}

base_python=""
find_python() {
    if [ -n "${PYTHON:-}" ]; then
        is_new_enough "$PYTHON" || fail "PYTHON=$PYTHON is not a Python 3.11 or newer."
        base_python=$PYTHON
        return
    fi
    for name in python3 python3.14 python3.13 python3.12 python3.11; do
        if is_new_enough "$name"; then
            base_python=$name
            return
        fi
    done
    if command -v python3 >/dev/null 2>&1; then
        fail "Python 3.11 or newer is needed; python3 here is $(python3 -V 2>&1 | sed 's/Python //')." \
            "With a newer one installed elsewhere: PYTHON=/path/to/python3 sh bootstrap.sh ..."
    fi
    say "there is no python3."
    apt_install python3 python3-venv || exit 2
    is_new_enough python3 || fail "Python 3.11 or newer is needed; this system's is $(python3 -V 2>&1 | sed 's/Python //')."
    base_python=python3
}

# Prints what the dynamic linker does not find: libraries of Gmsh, and "drawing" where there is nothing for VTK.
missing_libraries() { # $1: a Python
    "$1" - <<'PYTHON'
import ctypes


def is_there(name):
    try:
        ctypes.CDLL("lib" + name)
    except OSError:
        return False
    return True


gmsh = """GLU.so.1 GL.so.1 Xrender.so.1 Xcursor.so.1 Xfixes.so.3 Xext.so.6 Xft.so.2 fontconfig.so.1 Xinerama.so.1
          X11.so.6 gomp.so.1"""
print(*("lib" + name for name in gmsh.split() if not is_there(name)))
print("" if any(map(is_there, ("EGL.so.1", "OSMesa.so.8", "OSMesa.so.6"))) else "drawing")
PYTHON
}

# All that is missing in one go. Without what Gmsh needs, demo and test stop; run goes on, since a mesh may be there.
see_to_packages() { # $1: the command
    packages=""
    missing=""
    if [ -n "$base_python" ] && ! "$base_python" -c 'import ensurepip, venv' >/dev/null 2>&1; then
        # Debian keeps these in a package of its own.
        case $(command -v "$base_python") in
            /usr/bin/python3) packages=python3-venv ;;
            *) packages=$("$base_python" -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])') ;;
        esac
    fi
    needs_venv=$packages
    if [ "$(uname -s)" = Linux ]; then
        found=$(missing_libraries "${base_python:-$python}")
        missing=$(printf '%s\n' "$found" | sed -n 1p)
        if [ -n "$missing" ]; then
            say "not there, but needed by Gmsh: $missing"
            packages="$packages $gmsh_packages"
        fi
        if [ "$(printf '%s\n' "$found" | sed -n 2p)" = drawing ]; then
            say "not there, but needed for pictures without a display: libEGL.so.1 (or libOSMesa.so.8)"
            packages="$packages $picture_packages"
        fi
    fi
    # shellcheck disable=SC2086 # a list of names
    if [ -n "$packages" ] && ! apt_install $packages; then
        if [ -n "$needs_venv" ] || { [ -n "$missing" ] && [ "$1" != run ]; }; then
            exit 2
        fi
        say "going on; what needs these libraries will fail and say so"
    fi
}

# has_venv: whether .venv is there with a Python that will do and pip; also false for one left half made.
has_venv() {
    [ -x "$python" ] && is_new_enough "$python" && "$python" -m pip --version >/dev/null 2>&1
}

make_venv() {
    [ -n "$base_python" ] || return 0
    if [ -e "$venv" ]; then
        say ".venv has no working Python 3.11 or newer with pip; making it anew"
    fi
    say "making .venv with $("$base_python" -V 2>&1)"
    "$base_python" -m venv --clear "$venv" || fail "$base_python could not make a virtual environment in $venv."
}

# Installs the checkout itself (editable) with the pinned versions, unless the stamp says that it is done.
install_project() { # $1: "" or "test"
    stamp=$venv/bootstrap-installed
    wanted=$(cd "$root" && cat pyproject.toml constraints.txt bootstrap.sh | cksum)
    wanted="$wanted $root"
    extras=$1
    if [ -f "$stamp" ]; then
        case $(sed -n 2p "$stamp") in *test*) extras="test" ;; esac # do not fall back behind what is there
        if [ "$(sed -n 1p "$stamp")" = "$wanted" ] && [ "$(sed -n 2p "$stamp")" = "extras $extras" ]; then
            return
        fi
    fi
    rm -f "$stamp"
    what=$extras
    case $(uname -s)-$(uname -m) in Linux-x86_64 | Linux-amd64) what="pardiso${extras:+,mpi,$extras}" ;; esac
    say "installing bsm-mesh and the pinned versions of what it needs into .venv; a minute or a few, once"
    if ! {
        pip_install setuptools && pip_install --no-build-isolation -e "$root${what:+[$what]}"
    }; then
        if [ "$(uname -s)" = Linux ] && [ "$(uname -m)" != x86_64 ]; then
            say "Gmsh publishes no wheel for Linux on $(uname -m): docs/installation.md says what can be done."
        fi
        fail "pip could not install what is needed (its last lines say why). The same command tries again."
    fi
    printf '%s\nextras %s\n' "$wanted" "$extras" >"$stamp"
}

pip_install() {
    PIP_USER=0 PIP_DISABLE_PIP_VERSION_CHECK=1 "$python" -m pip install -q -c "$root/constraints.txt" "$@" >&2
}

# VTK ends a renderer without its libraries with a segmentation fault, so only a trial in a process of its own tells.
can_draw() {
    (
        # shellcheck disable=SC3045
        ulimit -c 0 2>/dev/null || : # no core file; not every shell knows it
        : "${VTK_DEFAULT_OPENGL_WINDOW:=vtkEGLRenderWindow}"
        export VTK_DEFAULT_OPENGL_WINDOW
        "$python" - <<'PYTHON'
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow

window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.AddRenderer(vtkRenderer())
window.Render()
PYTHON
        exit $? # keeps a shell here, whose words about the fault go where its output goes
    ) >/dev/null 2>&1
}

see_to_pictures() {
    if [ "$(uname -s)" != Linux ] || [ -f "$venv/bootstrap-draws" ]; then
        return 0
    fi
    # shellcheck disable=SC2086 # a list of names
    if can_draw || { say "VTK cannot draw here without a display"; apt_install $picture_packages && can_draw; }; then
        : >"$venv/bootstrap-draws"
    else
        say "going on without pictures; docs/installation.md says what can be done."
    fi
}

# Numba's own cache does not notice a change in a function that another file's function calls; here each state
# of the sources has a cache of its own.
choose_numba_cache() {
    if [ -z "${NUMBA_CACHE_DIR:-}" ]; then
        state=$(cd "$root" && find bsm_mesh geometries converters -name '*.py' -exec cksum {} + | sort -k 3 | cksum)
        NUMBA_CACHE_DIR=$venv/numba-cache/$(echo "$state" | tr ' ' '-')
        export NUMBA_CACHE_DIR
        if [ ! -d "$NUMBA_CACHE_DIR" ]; then
            mkdir -p "$NUMBA_CACHE_DIR"
            find "$venv/numba-cache" -type d -name '[0-9]*' -prune -mtime +7 -exec rm -rf {} +
        fi
    fi
}

# -------------------------------------------------------------------------------------------------- tests

passed=0
failed=0
summary=""

# check NAME COMMAND...: runs it, says how it went, and goes on.
check() {
    name=$1
    shift
    printf '\n== %s: %s\n' "$name" "$*"
    begin=$(date +%s)
    code=0
    "$@" || code=$?
    line="$name ($(($(date +%s) - begin)) s)"
    if [ "$code" = 0 ]; then
        line="PASS  $line"
        passed=$((passed + 1))
    else
        line="FAIL  $line, exit code $code"
        failed=$((failed + 1))
    fi
    printf '%s\n' "$line"
    summary="$summary$line
"
}

# pytest's exit code 5 means that it found no test; that is a pass only where there is none to be found.
run_tests() {
    code=0
    "$python" -m pytest -n 2 --dist loadfile -m "not slow" || code=$?
    if [ "$code" = 5 ] && [ -z "$(find tests -name 'test_*.py' 2>/dev/null)" ]; then
        code=0
    fi
    return "$code"
}

run_doctests() {
    code=0
    "$python" -m pytest --doctest-modules bsm_mesh || code=$?
    if [ "$code" = 5 ] && [ -z "$(find bsm_mesh geometries converters -name '*.py' -exec grep -l '>>> ' {} +)" ]; then
        code=0
    fi
    return "$code"
}

test_all() {
    cd "$root"
    # Two workers share the machine: one thread each, unless the caller says otherwise.
    export OMP_NUM_THREADS="${OMP_NUM_THREADS:-1}" OPENBLAS_NUM_THREADS="${OPENBLAS_NUM_THREADS:-1}"
    export MKL_NUM_THREADS="${MKL_NUM_THREADS:-1}"
    check "formatter" "$python" -m ruff format --check .
    check "linter" "$python" -m ruff check .
    check "types" "$python" -m mypy
    check "doctests" run_doctests
    check "tests" run_tests
    printf '\n%s\nchecks: %s passed, %s failed\n' "$summary" "$passed" "$failed"
    [ "$failed" = 0 ]
}

# --------------------------------------------------------------------------------------------------- main

[ $# -ge 1 ] || usage
command=$1
shift
case $command in
    demo | run) extra="" ;;
    test) [ $# = 0 ] || usage; extra="test" ;;
    *) usage ;;
esac

has_venv || find_python
see_to_packages "$command"
make_venv
install_project "$extra"
see_to_pictures
choose_numba_cache

case $command in
    test) test_all ;;
    *) exec "$venv/bin/bsm-mesh" "$command" "$@" ;;
esac
