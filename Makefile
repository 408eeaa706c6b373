# make demo: a real map corrected, pictures in out/demo/.   make test: everything that must hold.
# make results: docs/RESULTS.md measured anew.              make bench: timings (criterion).

HITL := target/release/hitl
DEMO := out/demo

.PHONY: demo test results bench system

demo: system
	cargo build --release --locked
	@mkdir -p $(DEMO)
	$(HITL) import data/aces.clf.bz2 -o $(DEMO)/before.npz
	$(HITL) evaluate $(DEMO)/before.npz --relations data/aces.relations --report $(DEMO)/error-before.json
	$(HITL) correct $(DEMO)/before.npz --corrections data/aces.corrections.jsonl -o $(DEMO)/after.npz \
	  --trajectory $(DEMO)/trajectory.tum --report $(DEMO)/report.json --pictures $(DEMO)
	$(HITL) evaluate $(DEMO)/after.npz --relations data/aces.relations --report $(DEMO)/error-after.json
	@echo "pictures: $(DEMO)/before.png $(DEMO)/after.png $(DEMO)/before-after.png"
	@echo "corrected trajectory: $(DEMO)/trajectory.tum   report: $(DEMO)/report.json"

# The build without Ceres: what it solves, and what it says. Before the others, so that the program left behind has Ceres.
WITHOUT_CERES := joint:: solver:: cli::crosscheck cli::optimize cli::usage

# One set of build products for everything that runs: the release profile.
test: system
	cargo fmt --check
	cargo clippy --release --locked --all-targets -- -D warnings
	HITL_REQUIRE_CERES=0 cargo clippy --release --locked --all-targets --no-default-features -- -D warnings
	HITL_REQUIRE_CERES=0 cargo test --release --locked --no-default-features --test main -- $(WITHOUT_CERES)
	HITL_REQUIRE_CERES=1 cargo test --release --locked
	RUSTDOCFLAGS="-D warnings" cargo doc --release --locked --no-deps

results: system
	cargo build --release --locked
	cargo bench --locked --bench results

bench: system
	cargo bench --locked --bench timing

system:
	@sh .ci/system
