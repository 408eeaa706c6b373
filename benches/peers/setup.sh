#!/bin/sh
# The Python peers of the side-by-side benchmark, in a virtual environment of their own: target/peers/venv.
# Never required: without it `cargo bench --bench results -- solvers` leaves GTSAM and g2o out and says so.
set -eu
cd "$(dirname "$0")/../.."
# All or nothing: half a virtual environment would be taken for a whole one.
trap '[ $? -eq 0 ] || rm -rf target/peers/venv' EXIT
python3 -m venv target/peers/venv
target/peers/venv/bin/pip install --quiet gtsam==4.3.0 g2opy==2.3.0 numpy
target/peers/venv/bin/python -c 'import gtsam, g2opy'
echo "target/peers/venv: GTSAM 4.3.0 and g2o (g2opy 2.3.0)"
