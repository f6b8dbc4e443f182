//! The report of `slipstream check` as text.

use std::fmt;

use super::report::{Report, Severity, StreamReport};

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.recording)?;
        for robot in &self.robots {
            writeln!(f, "\n{}", robot.robot)?;
            for stream in &robot.streams {
                writeln!(f, "  {stream}")?;
            }
        }
        if !self.findings.is_empty() {
            writeln!(f, "\nfound")?;
        }
        for finding in &self.findings {
            let severity = match finding.severity {
                Severity::Error => "ERROR",
                Severity::Warning => "warning",
                Severity::Note => "note",
            };
            let robot = finding.robot.as_deref().unwrap_or("all");
            let (statement, remedy) = (&finding.statement, &finding.remedy);
            writeln!(f, "  {severity:7} {robot}: {statement}; {remedy}")?;
        }
        list(f, "can be judged", &self.can_judge)?;
        list(f, "missing", &self.missing)
    }
}

fn list(f: &mut fmt::Formatter<'_>, title: &str, lines: &[String]) -> fmt::Result {
    if lines.is_empty() {
        return Ok(());
    }
    writeln!(f, "\n{title}")?;
    lines.iter().try_for_each(|line| writeln!(f, "  {line}"))
}

impl fmt::Display for StreamReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:9}{:>8} rows", self.stream, self.rows)?;
        if let Some([start, end]) = self.span_s {
            write!(f, "  {start:.2} to {end:.2} s")?;
        }
        if let (Some(rate), Some(jitter)) = (self.rate_hz, self.jitter) {
            write!(f, "  {rate:.1} Hz  jitter {:.0} %", 100.0 * jitter)?;
        }
        if !self.gaps_s.is_empty() {
            write!(f, "  {} gaps", self.gaps_s.len())?;
        }
        if self.empty_cells > 0 {
            write!(f, "  {} empty cells", self.empty_cells)?;
        }
        write!(f, "  {}", self.columns.join(","))
    }
}
