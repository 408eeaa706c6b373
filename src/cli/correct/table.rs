//! The report for a person.

use super::report::{Entry, Report};

/// One line per correction and a summary.
pub fn text(report: &Report, interpret_only: bool) -> String {
    let mut text = format!("{} poses, {} points\n", report.poses, report.observations);
    let width = report.corrections.iter().map(|c| c.id.chars().count()).max().unwrap_or(0).max(2);
    for c in &report.corrections {
        let mut what = if interpret_only { interpretation(c) } else { correction(c) };
        for stroke in c.unsettled() {
            what.push_str(&format!("  (EM of stroke {stroke} not settled)"));
        }
        text.push_str(&format!("  {:<width$}  {:<13}  {what}\n", c.id, c.mode.name()));
    }
    if !interpret_only {
        let (accepted, all) =
            (report.corrections.iter().filter(|c| c.accepted).count(), report.corrections.len());
        text.push_str(&format!("{accepted} of {all} corrections applied in {:.0} ms\n", report.total_ms));
        report.contradictions.iter().for_each(|c| text.push_str(&c.text()));
    }
    text
}

fn correction(c: &Entry) -> String {
    if !c.accepted {
        return format!("rejected: {}", c.reason.as_deref().unwrap_or("no reason given"));
    }
    let offset = match (c.offset_before_m, c.offset_after_m) {
        (Some(before), Some(after)) => format!("{:8.1} → {:.1} cm", 100.0 * before, 100.0 * after),
        _ => format!("{:>8}", "–"),
    };
    let angle = match (c.angle_before_rad, c.angle_after_rad) {
        (Some(before), Some(after)) => format!("{:6.2} → {:.2}°", before.to_degrees(), after.to_degrees()),
        _ => String::new(),
    };
    let converged = match c.termination {
        Some(t) if t.starts_with("converged") => String::new(),
        Some(t) => format!("  NOT CONVERGED ({t})"),
        None => String::new(),
    };
    format!(
        "{offset:<20}  {angle:<16}  {:>3}+{:<3} poses  {:>2} iterations  {:>6.1} ms{converged}",
        c.poses_a, c.poses_b, c.iterations, c.total_ms
    )
}

fn interpretation(c: &Entry) -> String {
    if let Some(reason) = &c.reason {
        return format!("would be rejected: {reason}");
    }
    format!(
        "earlier feature {} points of {} poses, later {} points of {} poses; now {}{:.2}° off",
        c.observations_a,
        c.poses_a,
        c.observations_b,
        c.poses_b,
        c.offset_before_m.map_or(String::new(), |m| format!("{:.1} cm apart, ", 100.0 * m)),
        c.angle_before_rad.unwrap_or(0.0).to_degrees()
    )
}
