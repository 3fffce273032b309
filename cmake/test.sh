#!/usr/bin/env bash
# Everything: set-up, build, C++ and Python tests, checks, and the core's tests once more under sanitizers.
# Every suite runs even if an earlier one failed; the last line sums them up.
#   GLENOID_TEST_COUNT  random cases per law (the suites' own default if unset)
set -uo pipefail
cd "$(dirname "$0")/.."
reports=$PWD/build/reports
failed=0
stage() { echo; echo "== $*"; }

stage set-up and build
bash cmake/setup.sh && bash cmake/build.sh release || { echo "0 passed, 1 failed, 0 skipped"; exit 1; }
rm -rf "$reports"
mkdir -p "$reports"

stage C++ tests
ctest --test-dir build -j "${GLENOID_JOBS:-2}" --output-on-failure --output-junit "$reports/ctest.xml" >"$reports/ctest.log" 2>&1 ||
  { failed=1; grep -vE '^ +Start|Test .*Passed' "$reports/ctest.log"; }
tail -n 3 "$reports/ctest.log"

run_pytest() {
  local report=$1
  shift
  build/venv/bin/python -m pytest -q --junitxml="$reports/$report.xml" --durations=10 "$@" || failed=1
}
stage Python tests
run_pytest pytest -n "${GLENOID_JOBS:-2}" --dist loadfile tests/host tests/fmu tests/validation tests/architecture

stage Python tests that run programs against the clock, one after another
run_pytest programs tests/bus tests/vcan tests/rehearsal

stage checks
bash cmake/check.sh | tee "$reports/check.log"
[ "${PIPESTATUS[0]}" -eq 0 ] || failed=1

# The planner end to end and the kinematics; building the other tests with sanitizers takes longer than everything above.
# All of them: cmake --workflow --preset sanitize
stage planner and kinematics under the address and undefined-behaviour sanitizers
if bash cmake/build.sh sanitize robustness kinematics_test limits_test; then
  GLENOID_TEST_COUNT=${GLENOID_TEST_COUNT_SANITIZE:-20} \
    ctest --test-dir build/sanitize -R '^(robustness$|InverseKinematics|ForwardKinematics|PostureFrom|Limit)' \
    -j "${GLENOID_JOBS:-2}" --output-on-failure --output-junit "$reports/sanitize.xml" \
    >"$reports/sanitize.log" 2>&1 || { failed=1; cat "$reports/sanitize.log"; }
  tail -n 3 "$reports/sanitize.log"
else
  failed=1
fi

stage sum
/usr/bin/python3 cmake/count_tests.py "$reports" || failed=1
exit $failed
