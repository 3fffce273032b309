"""Adds up the reports of all suites and prints `N passed, N failed, N skipped`; exit 1 unless all suites reported."""

import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

SUITES = ("ctest", "pytest", "programs", "sanitize")


def count_cases(report: Path) -> tuple[int, int, int]:
    """Passed, failed and skipped cases of one JUnit file."""
    cases = list(ElementTree.parse(report).iter("testcase"))
    failed = sum(case.find("failure") is not None or case.find("error") is not None for case in cases)
    skipped = sum(case.find("skipped") is not None for case in cases)
    return len(cases) - failed - skipped, failed, skipped


def count_checks(log: Path) -> tuple[int, int, int]:
    """Passed and failed lines of check.sh."""
    lines = [line for line in log.read_text(encoding="utf-8").splitlines() if line.startswith("check ")]
    passed = sum(line.endswith(": passed") for line in lines)
    return passed, len(lines) - passed, 0


def main(folder: Path) -> int:
    """Sum of the reports in a folder; a suite without a report counts as one failure."""
    missing = [suite for suite in SUITES if not (folder / f"{suite}.xml").is_file()]
    counts = {suite: count_cases(folder / f"{suite}.xml") for suite in SUITES if suite not in missing}
    counts["checks"] = count_checks(folder / "check.log")
    counts |= dict.fromkeys(missing, (0, 1, 0))
    for suite, (passed, failed, skipped) in counts.items():
        print(f"{suite:10s} {passed} passed, {failed} failed, {skipped} skipped")
    passed, failed, skipped = (sum(column) for column in zip(*counts.values(), strict=True))
    print(f"{passed} passed, {failed} failed, {skipped} skipped")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
