# Commands for people and for CI. Every target installs what it needs.
# The first Python that is at least 3.11 and can make environments, unless PYTHON is given; uv, where it is there, finds one itself.
PYTHON ?= $(shell for python in python3.11 python3.12 python3.13 python3.14 python3; do \
	"$$python" -c "import ensurepip, sys; sys.exit(sys.version_info < (3, 11))" 2> /dev/null && echo "$$python" && break; done)
BIN := .venv/bin

# Into .venv, with the extras of the argument.
define install
	@if command -v uv > /dev/null; then \
		uv venv --quiet --allow-existing --python "$(or $(PYTHON),3.13)" .venv && uv pip install --quiet --python "$(BIN)/python" --editable "$(1)"; \
	elif [ -n "$(PYTHON)" ]; then \
		"$(PYTHON)" -m venv .venv && "$(BIN)/python" -m pip install --quiet --disable-pip-version-check --editable "$(1)"; \
	else \
		echo "No Python from 3.11 to 3.14 with the module venv was found. Install one (on Debian and Ubuntu: apt install python3 python3-venv)" \
			"or uv, or name one: make PYTHON=/path/to/python3" >&2; exit 2; \
	fi
endef

.PHONY: demo paper gallery test check docs bench validate slow soak intervals fuzz install clean

demo: .venv/.run
	@"$(BIN)/shockpc" analyze quadruped --contact hind_foot --plane xz --out out/quadruped
	@echo
	@"$(BIN)/shockpc" analyze anymal_b --contact LF_FOOT --out out/anymal_b
	@echo
	@echo "The figures: out/quadruped/shock.png and out/anymal_b/shock.png (shock.svg beside each)"

paper: .venv/.run
	@"$(BIN)/shockpc" paper --out out/paper
	@echo
	@echo "Figures, tables and scenes: out/paper"

# The pictures of the README and the guide.
gallery: paper .venv/.dev
	@"$(BIN)/shockpc" analyze go2 --contact FL_foot+FR_foot --out out/go2 > /dev/null
	@cp out/go2/shock.svg robots/gallery/go2.svg
	@"$(BIN)/shockpc" place go2 --out out/place_go2 > /dev/null
	@cp out/place_go2/place.svg robots/gallery/place_go2.svg
	@"$(BIN)/shockpc" recorded robots/measured/cassie_landings.csv robots/measured/cassie.toml --map second_foot_later_ms= \
		--map "ankle_spring_joint_*=" --joints geared --out out/cassie > /dev/null
	@cp out/cassie/measured.svg robots/gallery/cassie.svg
	@cp out/paper/figure*.svg robots/gallery/
	@"$(BIN)/shockpc" sweep anymal_b --contact LF_FOOT --vary "*_KFE=-120:-10:200" --vary strike-angle=0:75:16 --at imu_link --rows csv --out out/sweep
	@"$(BIN)/shockpc" compare go2 --contact FL_foot --change "mass:*_calf=0.9x" --out out/compare > /dev/null
	@"$(BIN)/shockpc" limits hyq --contact lf_foot --joint lf_kfe_joint --at trunk_imu --max 0.1 --range -150:0 --out out/limits > /dev/null
	@"$(BIN)/shockpc" sensitivity anymal_b --contact LF_FOOT --at imu_link --out out/sensitivity > /dev/null
	@"$(BIN)/shockpc" place anymal_b --vary strike-angle=-30:75:8 --out out/place > /dev/null
	@"$(BIN)/shockpc" fall g1 --out out/fall > /dev/null
	@"$(BIN)/shockpc" paper --beyond --out out/beyond > /dev/null
	@cp out/beyond/robots.svg robots/gallery/bending.svg
	@"$(BIN)/shockpc" analyze anymal_b --contact LF_FOOT --drop-height 0.3 --pulse half-sine:15ms \
		--part "imu_link=half-sine 1500 g 0.5 ms" --part "LF_SHANK=half-sine 50 g 11 ms" --out out/part > /dev/null
	@awk -F, 'NR == 1 || $$3 > 0.006' robots/measured/elbow/elbow_landings.csv > out/elbow.csv
	@"$(BIN)/shockpc" identify out/elbow.csv $(UNKNOWN) --out out/identify > /dev/null
	@cp out/fall/fall.svg out/part/damage_boundary.svg out/identify/identify.svg out/sweep/sweep.svg out/compare/compare.svg out/limits/limits.svg out/sensitivity/sensitivity.svg out/place/place.svg robots/gallery/

test: .venv/.dev
	@"$(BIN)/python" -m pytest -n auto --dist worksteal --durations 10

check: .venv/.dev
	@"$(BIN)/ruff" format --check shockpc tests .github/docs
	@"$(BIN)/ruff" check shockpc tests .github/docs
	@"$(BIN)/mypy"
	@"$(BIN)/lint-imports"
	@"$(BIN)/python" tests/row_path.py
	@"$(BIN)/python" tests/readability.py

# The site of the documentation, in out/docs: guide, notebooks, reference, quantities and figures. A warning is an error.
docs: .venv/.docs
	@"$(BIN)/python" .github/docs/pages.py out/docs
	@echo "The site: out/docs/index.html"

# Error against run time, with a report in out/bench.
bench: .venv/.dev
	@"$(BIN)/shockpc" bench --out out/bench

# Measured landings against predicted ones, by joint model; TABLE may be another one with the same columns. Then the tosses of two
# hinged blocks that struck with one corner, by law of contact: a contact that sticks, friction, friction and restitution; and what
# these, and all tosses, say of friction and restitution. Then the heel strikes of a compass-gait biped.
TABLE ?= robots/measured/cassie_landings.csv
VALIDATE = "$(BIN)/shockpc" recorded "$(TABLE)" robots/measured/cassie.toml --map second_foot_later_ms= --map "ankle_spring_joint_*="
ELBOW = "$(BIN)/shockpc" recorded out/validate/elbow.csv robots/measured/elbow/elbow.urdf --map gap=
SYDNEY = robots/measured/sydney
UNKNOWN = robots/measured/elbow/elbow.urdf --map gap= --unknown friction=0:1.5 --unknown restitution=0:1
validate: .venv/.dev
	@$(VALIDATE) --joints geared,free --contact-stiffness 1e5 --out out/validate
	@$(VALIDATE) --lock "knee_joint_*" --lock "heel_spring_*" --out out/validate/springs_rigid
	@mkdir -p out/validate
	@awk -F, 'NR == 1 || $$3 > 0.006' robots/measured/elbow/elbow_landings.csv > out/validate/elbow.csv
	@$(ELBOW) --out out/validate/elbow_sticks
	@$(ELBOW) --friction 0.2 --out out/validate/elbow_friction
	@$(ELBOW) --friction 0.2 --restitution 0.2 --out out/validate/elbow_friction_restitution
	@"$(BIN)/shockpc" identify out/validate/elbow.csv $(UNKNOWN) --out out/validate/elbow_identified
	@"$(BIN)/shockpc" identify robots/measured/elbow/elbow_landings.csv $(UNKNOWN) --out out/validate/elbow_all_identified
	@"$(BIN)/shockpc" recorded $(SYDNEY)/landings.csv $(SYDNEY)/sydney_compass_gait.urdf --base planar --joints free --directions xz \
		--out out/validate/sydney

# Tests that take longer than the suite has for them.
slow: .venv/.dev
	@"$(BIN)/python" -m pytest -n auto -m slow --durations 10

# These, and reported bounds against an independent solution on random landings; after an interrupt it says how to continue.
N ?= 100000
FROM ?= 0
soak: slow
	@"$(BIN)/python" tests/soak.py "$(N)" --from "$(FROM)"

# How often the intervals of shockpc identify hold the true values of simulated landings; N draws, 300 unless it is given.
intervals: .venv/.dev
	@"$(BIN)/python" tests/identify_draws.py $(if $(filter command line,$(origin N)),"$(N)",300)

# Commands on hostile files; after an interrupt it says how to continue.
fuzz: .venv/.dev
	@"$(BIN)/python" tests/fuzz.py "$(N)" --from "$(FROM)"

install: .venv/.run

.venv/.run: pyproject.toml
	$(call install,.)
	@touch "$@"

.venv/.dev: pyproject.toml
	$(call install,.[dev])
	@touch "$@" .venv/.run

.venv/.docs: pyproject.toml
	$(call install,.[docs])
	@touch "$@" .venv/.run

clean:
	@rm -rf .venv out build dist
