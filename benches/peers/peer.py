"""GTSAM and g2o on a g2o file: `peer.py gtsam-gn|gtsam-lm|g2o-gn GRAPH REPEATS POSES`.

Prints `cpu_ms iterations load_ms`, the fastest of REPEATS solves: ordering and symbolic analysis are in it, reading and building
the graph are not. Writes the final poses, a line `x y theta` each.
"""

import sys
import time


def milliseconds(since):
    return 1e3 * (time.process_time() - since)


def gtsam_peer(graph_file, repeats, use_lm):
    import gtsam
    import numpy as np

    begin = time.process_time()
    start = gtsam.Values()
    factors = gtsam.NonlinearFactorGraph()
    with open(graph_file) as lines:
        for line in lines:
            words = line.split()
            if words[0] == "VERTEX_SE2":
                start.insert(int(words[1]), gtsam.Pose2(*map(float, words[2:5])))
            elif words[0] == "EDGE_SE2":
                x, y, t, xx, xy, xt, yy, yt, tt = map(float, words[3:12])
                omega = np.array([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]])
                noise = gtsam.noiseModel.Gaussian.Information(omega)
                factors.add(
                    gtsam.BetweenFactorPose2(int(words[1]), int(words[2]), gtsam.Pose2(x, y, t), noise)
                )
    held = gtsam.noiseModel.Isotropic.Sigma(3, 1e-6)
    factors.add(gtsam.PriorFactorPose2(0, start.atPose2(0), held))
    load_ms = milliseconds(begin)
    best = float("inf")
    for _ in range(repeats):
        begin = time.process_time()
        if use_lm:
            params = gtsam.LevenbergMarquardtParams()
            optimizer = gtsam.LevenbergMarquardtOptimizer
        else:
            params = gtsam.GaussNewtonParams()
            optimizer = gtsam.GaussNewtonOptimizer
        params.setRelativeErrorTol(1e-6)
        params.setAbsoluteErrorTol(1e-6)
        params.setMaxIterations(100)
        solver = optimizer(factors, start, params)
        result = solver.optimize()
        best = min(best, milliseconds(begin))
    poses = [result.atPose2(k) for k in range(start.size())]
    return best, solver.iterations(), load_ms, [(p.x(), p.y(), p.theta()) for p in poses]


def g2o_peer(graph_file, repeats):
    import g2opy as g2o

    best = float("inf")
    for _ in range(repeats):
        begin = time.process_time()
        optimizer = g2o.SparseOptimizer()
        solver = g2o.BlockSolverSE2(g2o.LinearSolverEigenSE2())
        optimizer.set_algorithm(g2o.OptimizationAlgorithmGaussNewton(solver))
        if not optimizer.load(graph_file):
            raise SystemExit("g2o cannot read " + graph_file)
        optimizer.vertex(0).set_fixed(True)
        load_ms = milliseconds(begin)
        begin = time.process_time()
        optimizer.initialize_optimization()
        iterations = optimizer.optimize(10)
        best = min(best, milliseconds(begin))
    estimates = [optimizer.vertex(k).estimate().to_vector() for k in range(len(optimizer.vertices()))]
    return best, iterations, load_ms, estimates


def main():
    peer, graph_file, repeats, poses_file = sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4]
    if peer == "g2o-gn":
        cpu_ms, iterations, load_ms, poses = g2o_peer(graph_file, repeats)
    else:
        cpu_ms, iterations, load_ms, poses = gtsam_peer(graph_file, repeats, peer == "gtsam-lm")
    with open(poses_file, "w") as out:
        for pose in poses:
            out.write(" ".join(repr(float(v)) for v in pose) + "\n")
    print(cpu_ms, iterations, load_ms)


if __name__ == "__main__":
    main()
