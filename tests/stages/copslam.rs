//! Stage 4 against its definition: exact end, shares by variance, linear time.

use hitl_slam::copslam::distribute;
use hitl_slam::geometry::{Pose2, angle_diff};

use crate::support::Dice;

fn chain(random: &mut Dice, poses: usize) -> Vec<Pose2> {
    let mut chain = vec![random.pose()];
    for k in 1..poses {
        let step = Pose2::new(random.uniform(0.1, 0.3), random.normal(0.02), random.normal(0.2));
        chain.push(chain[k - 1].compose(step));
    }
    chain
}

#[test]
fn the_last_pose_ends_exactly_on_its_target_and_the_first_stays() {
    let mut random = Dice::new(11);
    for _ in 0..200 {
        let poses = chain(&mut random, 80);
        let variances: Vec<_> =
            (1..80).map(|_| (random.uniform(0.0, 1e-3), random.uniform(0.0, 1e-4))).collect();
        let target = random.pose();
        let mut bent = poses.clone();
        distribute(&mut bent, &variances, target);
        assert_eq!(bent[0], poses[0]);
        assert!((bent[79].translation() - target.translation()).norm() < 1e-9);
        assert!(angle_diff(bent[79].theta_rad, target.theta_rad).abs() < 1e-9);
    }
}

#[test]
fn every_step_turns_in_proportion_to_its_variance() {
    let mut random = Dice::new(12);
    let poses = chain(&mut random, 40);
    let variances: Vec<_> = (1..40).map(|k| (1e-4, f64::from(k) * 1e-5)).collect();
    let total: f64 = variances.iter().map(|v| v.1).sum();
    let end = poses[39];
    let target = Pose2::new(end.x_m + 0.4, end.y_m - 0.3, end.theta_rad + 0.2);
    let mut bent = poses.clone();
    distribute(&mut bent, &variances, target);
    for k in 0..39 {
        let turn = |p: &[Pose2]| angle_diff(p[k + 1].theta_rad, p[k].theta_rad);
        let gained = angle_diff(turn(&bent), turn(&poses));
        assert!((gained - 0.2 * variances[k].1 / total).abs() < 1e-9, "step {k}: {gained}");
    }
}

#[test]
fn a_pure_translation_moves_each_pose_by_its_cumulative_share() {
    let mut random = Dice::new(13);
    let poses = chain(&mut random, 30);
    let variances: Vec<_> = (1..30).map(|k| (f64::from(k), 1.0)).collect();
    let end = poses[29];
    let mut bent = poses.clone();
    distribute(&mut bent, &variances, Pose2::new(end.x_m + 1.0, end.y_m, end.theta_rad));
    for k in 0..30 {
        let share = (k * (k + 1)) as f64 / (29.0 * 30.0);
        assert!((bent[k].x_m - poses[k].x_m - share).abs() < 1e-9);
        assert!((bent[k].y_m - poses[k].y_m).abs() < 1e-9);
    }
}

#[test]
fn zero_variances_share_equally_and_a_missing_factor_takes_everything() {
    let poses: Vec<_> = (0..5).map(|k| Pose2::new(f64::from(k), 0.0, 0.0)).collect();
    let target = Pose2::new(4.0, 1.0, 0.0);
    let mut equal = poses.clone();
    distribute(&mut equal, &[(0.0, 0.0); 4], target);
    assert!(equal.iter().enumerate().all(|(k, p)| (p.y_m - k as f64 / 4.0).abs() < 1e-12));

    let mut torn = poses.clone();
    let loose = (f64::INFINITY, f64::INFINITY);
    distribute(&mut torn, &[(1e-4, 1e-5), loose, (1e-4, 1e-5), (1e-4, 1e-5)], target);
    assert!(torn[1].y_m.abs() < 1e-12 && (torn[2].y_m - 1.0).abs() < 1e-12);
}

#[test]
fn ten_times_the_poses_cost_about_ten_times_the_time() {
    // The released implementation is O(n²): that would be a factor of 100.
    let time = |poses: usize| {
        let mut random = Dice::new(14);
        let poses = chain(&mut random, poses);
        let variances = vec![(1e-4, 1e-5); poses.len() - 1];
        let fastest = (0..5).map(|_| {
            let mut bent = poses.clone();
            let start = std::time::Instant::now();
            distribute(&mut bent, &variances, Pose2::IDENTITY);
            start.elapsed().as_secs_f64()
        });
        fastest.fold(f64::INFINITY, f64::min)
    };
    let (small, large) = (time(20_000), time(200_000));
    assert!(large < 40.0 * small, "{small} s, then {large} s");
}
