# What a person types. Everything lands in build/; the scripts are in cmake/.
.PHONY: help demo test build check format clean

help:
	@echo "make demo    install what is missing, build, plan a measured reach, run the FMU, draw it, rehearse"
	@echo "make test    install what is missing, build, run every test and check"
	@echo "make build   the FMUs, the Python module, the tests"
	@echo "make check   formatting, lint and types, without repairing"
	@echo "make format  apply the formatting"

demo:
	@bash cmake/setup.sh
	@bash cmake/build.sh release glenoid_fmu_archives glenoid_python_stub glenoid_lcm_python glenoid-bridge glenoid-drives
	@build/venv/bin/glenoid demo

test:
	@bash cmake/test.sh

build:
	@bash cmake/setup.sh
	@bash cmake/build.sh release

check: build
	@bash cmake/check.sh

format:
	@bash cmake/setup.sh
	@bash cmake/check.sh --apply

clean:
	rm -rf build
