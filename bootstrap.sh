#!/bin/sh
# Sets up bsm-mesh in .venv beside this file, if that is not done yet, and then runs it:
#
#     sh bootstrap.sh demo                      the whole chain on a built-in case
#     sh bootstrap.sh COMMAND ARGS...           the same as: .venv/bin/bsm-mesh COMMAND ARGS...
#     sh bootstrap.sh pardiso                   adds MKL's sparse solver, for large models; likewise mpi, dask, dxf, gis, pandas, pyvista
#     sh bootstrap.sh test [--all]              formatter, linter, types, doctests, tests; --all: more tests, documentation, lowest versions
#     sh bootstrap.sh docs                      the documentation as a site, in build/docs/html
#     sh bootstrap.sh matrix [--smoke] [NAME]   tests with the lowest and the newest versions, and with every Python
#
# What it needs and what it looks at is told in docs/installation.md. Its own words go to standard error,
# so that standard output is the program's.
# shellcheck disable=SC2030,SC2031 # test_environment is a subshell to have values of its own
set -eu

usage() {
    sed -n '2,9s/^# \{0,1\}//p' "$0" >&2
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
constraints=constraints.txt # in the root; "" for the newest versions there are

# What the libraries' names are in Debian and its relatives (docs/installation.md says which file needs which).
gmsh_packages="libglu1-mesa libgl1 libgomp1 libxcursor1 libxft2 libxinerama1"

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
    printf '\n    sudo apt-get update && sudo apt-get install --no-install-recommends %s\n\n' "$*" >&2
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
    # shellcheck disable=SC2046 # a list of names
    apt_install python3 python3-venv $([ "$(uname -s)" != Linux ] || echo "$gmsh_packages") || exit 2 # all in one go
    is_new_enough python3 || fail "Python 3.11 or newer is needed; this system's is $(python3 -V 2>&1 | sed 's/Python //')."
    base_python=python3
}

# Prints which libraries of Gmsh the dynamic linker does not find.
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
PYTHON
}

# All that is missing in one go. Without what Gmsh needs, demo, test and matrix stop; others go on, since a mesh may be there.
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
        missing=$(missing_libraries "${base_python:-$python}")
        if [ -n "$missing" ]; then
            say "not there, but needed by Gmsh: $missing"
            packages="$packages $gmsh_packages"
        fi
    fi
    # shellcheck disable=SC2086 # a list of names
    if [ -n "$packages" ] && ! apt_install $packages; then
        if [ -n "$needs_venv" ]; then
            exit 2
        fi
        case $1 in demo | test | matrix) [ -z "$missing" ] || exit 2 ;; esac
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
        say "$(basename "$venv") has no working Python 3.11 or newer with pip; making it anew"
    fi
    say "making $(basename "$venv") with $("$base_python" -V 2>&1)"
    "$base_python" -m venv --clear "$venv" || fail "$base_python could not make a virtual environment in $venv."
}

# What the daily tests want beyond the project itself: the solver is that of users, without MKL.
daily_extras=docs,test

# All extras of the tests: every solver that there is here.
test_extras() {
    case $(uname -s)-$(uname -m) in
        Linux-x86_64 | Linux-amd64) printf '%s,mpi,pardiso\n' "$daily_extras" ;;
        *) printf '%s\n' "$daily_extras" ;;
    esac
}

# Installs the checkout itself (editable) with the pinned versions, unless the stamp says that it is done.
install_project() { # $1: extras, with commas between; "" for none. What is there already stays.
    stamp=$venv/bootstrap-installed
    wanted=$(cd "$root" && cat pyproject.toml ${constraints:+"$constraints"} bootstrap.sh | cksum)
    wanted="$wanted $root"
    before=""
    if [ -f "$stamp" ]; then
        before=$(sed -n '2s/^extras //p' "$stamp")
    fi
    what=$(printf '%s\n' "$before" "$1" | tr ',' '\n' | sed '/^$/d' | sort -u | paste -sd , -)
    if [ -f "$stamp" ] && [ "$(sed -n 1p "$stamp")" = "$wanted" ] && [ "$before" = "$what" ]; then
        return
    fi
    rm -f "$stamp"
    say "installing bsm-mesh and what it needs into $(basename "$venv") (${constraints:-newest versions}); a minute or a few, once"
    if ! {
        pip_install --upgrade setuptools && pip_install --no-build-isolation -e "$root${what:+[$what]}"
    }; then
        if [ "$(uname -s)" = Linux ] && [ "$(uname -m)" != x86_64 ]; then
            say "Gmsh publishes no wheel for Linux on $(uname -m): docs/installation.md says what can be done."
        fi
        fail "pip could not install what is needed (its last lines say why). The same command tries again."
    fi
    printf '%s\nextras %s\n' "$wanted" "$what" >"$stamp"
}

# What to type from now on: the program is in .venv and not on the PATH.
say_how_to_go_on() {
    say "done. In every new terminal type the first line once; then bsm-mesh is a command:"
    printf '\n    . %s/bin/activate\n    bsm-mesh new slope my_slope && bsm-mesh run my_slope/model.toml\n\n' "$1" >&2
}

# Modules are compiled when they are imported: most never are, and all of them take a tenth of the space.
pip_install() {
    PIP_USER=0 PIP_DISABLE_PIP_VERSION_CHECK=1 "$python" -m pip install -q --no-compile ${constraints:+-c "$root/$constraints"} "$@" >&2
}

# Kernels are compiled once, into the package, where every way of calling finds them; what is there is not compiled again.
compile_kernels() {
    (cd "$root" && "$python" -m bsm_mesh.commands.precompile) || say "kernels could not be compiled now; a run compiles those that it needs"
}

# -------------------------------------------------------------------------------------------------- tests

report="" # a file with a line for each check

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
    else
        line="FAIL  $line, exit code $code"
    fi
    printf '%s\n' "$line" | tee -a "$report"
}

# with_report COMMAND...: runs it and sums up its checks; false where one of them failed.
with_report() {
    report=$(mktemp)
    trap 'rm -f "$report" "$report.beside"' EXIT
    "$@"
    passed=$(grep -c '^PASS' "$report") || true
    failed=$(grep -c '^FAIL' "$report") || true
    printf '\n%s\n\nchecks: %s passed, %s failed\n' "$(cat "$report")" "$passed" "$failed"
    [ "$failed" = 0 ]
}

# The daily tier has no test of signals, kills, full disks and wheels (robust), and none that is slow (heavy).
daily="not slow and not robust and not heavy"

# Tests that take MKL where it is there, and those whose numbers change most by it. The table of licences names MKL's;
# the others of test_numbers.py are made with the solver of users.
where_mkl_matters="tests/examples/test_examples.py tests/properties/test_invariants.py tests/unit/test_linear_solvers.py
    tests/unit/test_mixed_precision.py tests/unit/test_pardiso_mpi.py tests/verification/test_jointed_slope.py
    tests/unit/test_numbers.py::test_quick_tables_are_what_the_runs_say[licences]"

# pytest's exit code 5 means that it found no test; that is a pass only where there is none to be found.
run_tests() { # $1: which, as pytest's -m takes it; then files, all without
    code=0
    which=$1
    shift
    "$python" -m pytest -n 2 --dist worksteal -m "$which" --durations=25 "$@" || code=$?
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

# Two workers share the machine: one thread each, unless the caller says otherwise. Bytecode is kept in the environment,
# whatever the caller says: processes of tests, and the next run, start sooner.
share_the_machine() {
    export PYTHONPYCACHEPREFIX="${PYTHONPYCACHEPREFIX:-$venv/pycache}"
    unset PYTHONDONTWRITEBYTECODE
    export OMP_NUM_THREADS="${OMP_NUM_THREADS:-1}" OPENBLAS_NUM_THREADS="${OPENBLAS_NUM_THREADS:-1}"
    export MKL_NUM_THREADS="${MKL_NUM_THREADS:-1}"
}

# What tests do not depend on, one after the other.
checks_beside_tests() {
    check "formatter" "$python" -m ruff format --check .
    check "linter" "$python" -m ruff check .
    check "plain words" "$python" -m tools.words
    check "types" "$python" -m mypy
    if [ "$tier" = all ]; then
        check "documentation" "$python" -m docs.build
        (unset TEST_SECONDS && matrix --smoke lowest)
    fi
}

test_all() {
    cd "$root"
    share_the_machine
    # Side by side with the tests, so that no core waits for another; their words are shown afterwards.
    checks_beside_tests >"$report.beside" 2>&1 &
    check "doctests" run_doctests
    if [ "$tier" = all ]; then which="not slow"; else which=$daily; fi
    check "tests" run_tests "$which"
    wait $! || true
    cat "$report.beside"
    if [ "$tier" = all ]; then
        install_project "$(test_extras)"
        # The heavy examples have been solved above.
        # shellcheck disable=SC2086 # a list of names
        check "tests with MKL" run_tests "not slow" -k "not (test_examples and heavy)" $where_mkl_matters
    fi
}

# ------------------------------------------------------------------------------------------------- matrix

# What the libraries are used for, once each: command line, model file and units, meshes, cutting, VTU, pictures,
# continuum, linear solvers, DXF, and the wheel.
smoke_tests="tests/unit/test_wheel.py tests/unit/test_checkout.py tests/unit/test_cli.py
    tests/unit/test_model_file.py tests/unit/test_units.py tests/unit/test_session.py tests/unit/test_cases.py
    tests/unit/test_mesh_files.py tests/unit/test_vtk_files.py tests/unit/test_result_files.py tests/unit/test_pictures.py
    tests/unit/test_cut_blocks.py tests/unit/test_continuum.py tests/unit/test_continuum_supports.py
    tests/unit/test_linear_solvers.py tests/unit/test_orientations.py tests/unit/test_traces.py"

# interpreter 3.12: prints PYTHON or a name on the PATH that is a Python 3.12.
interpreter() {
    for candidate in ${PYTHON:+"$PYTHON"} "python$1" python3; do
        if [ "$("$candidate" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null)" = "$1" ]; then
            printf '%s\n' "$candidate"
            return
        fi
    done
    return 1
}

# test_environment NAME PYTHON: installs into an environment of its own, runs the tests there. In a subshell, for it
# changes what the functions above look at.
test_environment() (
    cd "$root" || exit
    venv=$root/.venv-matrix/$1
    python=$venv/bin/python
    base_python=$2
    if [ "$1" = newest ]; then
        rm -rf "$venv"
    elif has_venv && [ "$("$python" -V)" = "$("$base_python" -V)" ]; then
        base_python=""
    fi
    make_venv
    install_project "$(test_extras)"
    "$python" -m pip check || exit
    share_the_machine
    if [ "$smoke" = yes ]; then
        # One process compiles the kernels that these tests call, and none of the others.
        # shellcheck disable=SC2086 # a list of names
        "$python" -m pytest -q -m "not slow" $smoke_tests
    else
        compile_kernels
        run_tests "not slow"
    fi
)

matrix() {
    smoke=no
    if [ "${1:-}" = --smoke ]; then
        smoke=yes
        shift
    fi
    here=""
    for version in 3.11 3.12 3.13 3.14; do
        ! interpreter "$version" >/dev/null || here="$here $version"
    done
    [ $# != 0 ] || set -- lowest newest 3.11 3.12 3.13 3.14
    for name in "$@"; do
        version=$name
        constraints=constraints.txt
        case $name in
            lowest) version=3.11 constraints=constraints-lowest.txt ;;
            newest) version=${here##* } constraints="" ;;
            3.1[1-4]) ;;
            *) usage ;;
        esac
        if found=$(interpreter "$version"); then
            check "$name (Python $version)" test_environment "$name" "$found"
        else
            printf '\nSKIP  %s: no python%s on the PATH\n' "$name" "$version"
            printf 'SKIP  %s: no python%s on the PATH\n' "$name" "$version" >>"$report"
        fi
    done
}

# --------------------------------------------------------------------------------------------------- main

[ $# -ge 1 ] || usage
command=$1
shift
extra=""
case $command in
    test)
        tier=daily
        case "$*" in
            "") ;;
            --all) tier=all ;;
            *) usage ;;
        esac
        extra=$daily_extras
        ;;
    pardiso | mpi | dask | dxf | gis | pandas | pyvista | meshlane | docs) [ $# = 0 ] || usage; extra=$command ;;
    view) extra=view ;; # what the command draws with
    -*) usage ;;
esac

has_venv || find_python
see_to_packages "$command"
if [ "$command" = matrix ]; then
    with_report matrix "$@"
    exit
fi
make_venv
install_project "$extra"

case $command in
    test)
        compile_kernels
        with_report test_all
        ;;
    docs) cd "$root" && exec "$python" -m docs.build ;;
    pardiso | mpi | dask | dxf | gis | pandas | pyvista | meshlane) say "$command is installed in $(basename "$venv")" ;;
    demo)
        compile_kernels
        "$venv/bin/bsm-mesh" demo "$@"
        if [ "$(pwd -P)" = "$(cd "$root" && pwd -P)" ]; then say_how_to_go_on .venv; else say_how_to_go_on "$venv"; fi
        ;;
    *) exec "$venv/bin/bsm-mesh" "$command" "$@" ;;
esac
