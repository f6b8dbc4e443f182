//! Times in words.

/// Most times that are named.
const MOST_NAMED: usize = 3;

/// "at 3.20 s", or the first of several.
pub(crate) fn times(all_s: &[f64]) -> String {
    let named: Vec<String> = all_s
        .iter()
        .take(MOST_NAMED)
        .map(|t_s| format!("{t_s:.2} s"))
        .collect();
    let further = all_s.len().saturating_sub(MOST_NAMED);
    match further {
        0 => format!("at {}", named.join(", ")),
        _ => format!("at {} and {further} times more", named.join(", ")),
    }
}
