# make demo: a real map corrected, pictures in out/demo/.   make test: everything that must hold.
# make results: docs/RESULTS.md and docs/RESULTS-pedestrian.md measured anew.   make bench: timings (criterion), then our solver beside Ceres, GTSAM and g2o.

HITL := target/release/hitl
DEMO := out/demo

.PHONY: demo test page results bench peers system

demo: system
	cargo build --release --locked
	@mkdir -p $(DEMO)
	$(HITL) import data/intel.clf.bz2 --front-end scan-match -o $(DEMO)/before.npz
	$(HITL) evaluate $(DEMO)/before.npz --relations data/intel.relations --report $(DEMO)/error-before.json
	$(HITL) correct $(DEMO)/before.npz --corrections data/intel.corrections.jsonl -o $(DEMO)/after.npz \
	  --trajectory $(DEMO)/trajectory.tum --report $(DEMO)/report.json --pictures $(DEMO)
	$(HITL) evaluate $(DEMO)/after.npz --relations data/intel.relations --report $(DEMO)/error-after.json
	@echo "pictures: $(DEMO)/before.png $(DEMO)/after.png $(DEMO)/before-after.png"
	@echo "corrected trajectory: $(DEMO)/trajectory.tum   report: $(DEMO)/report.json"

# The build without Ceres: what it solves, and what it says. Before the others, so that the program left behind has Ceres.
WITHOUT_CERES := joint:: solver:: cli::crosscheck cli::optimize cli::usage

# One set of build products for everything that runs: the release profile.
test:
	@sh .ci/system page
	cargo fmt --check
	cargo clippy --release --locked --all-targets -- -D warnings
	HITL_REQUIRE_CERES=0 cargo clippy --release --locked --all-targets --no-default-features -- -D warnings
	HITL_REQUIRE_CERES=0 cargo test --release --locked --no-default-features --test main -- $(WITHOUT_CERES)
	HITL_REQUIRE_CERES=1 cargo test --release --locked
	RUSTDOCFLAGS="-D warnings" cargo doc --release --locked --no-deps
	$(MAKE) page

# The page of `hitl serve`: is the committed one what its source builds to, and does it work in a real browser?
page:
	cd page && npm ci --no-audit --no-fund --loglevel=error && npm run check && npm test

results:
	@sh .ci/system page
	cd page && npm ci --no-audit --no-fund --loglevel=error
	cargo build --release --locked
	cargo bench --locked --bench results
	cargo bench --locked --bench pedestrian_results

bench: system peers
	cargo bench --locked --bench timing
	cargo bench --locked --bench results -- solvers false-closures backends

# GTSAM and g2o are welcome, not needed.
peers:
	@test -x target/peers/venv/bin/python || sh benches/peers/setup.sh || echo "no GTSAM, no g2o: measuring without them"

system:
	@sh .ci/system
