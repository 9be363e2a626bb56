//! Long series, drawn with few points and without losing a peak.

/// Reduces a polyline in pixels to at most four points for each pixel column:
/// the first, the lowest, the highest and the last of every run of neighbours
/// in one column. Drawn as lines this covers the same pixels as the full
/// series (M4 aggregation: Jugel, Jerzak, Hackenbroich and Markl, "M4: a
/// visualization-oriented time series data aggregation", VLDB 2014).
pub(crate) fn decimate(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut kept = Vec::new();
    for run in points.chunk_by(|a, b| a.0.floor() == b.0.floor()) {
        if run.len() <= 4 {
            kept.extend_from_slice(run);
            continue;
        }
        let (mut lowest, mut highest) = (0, 0);
        for (i, point) in run.iter().enumerate() {
            if point.1 < run[lowest].1 {
                lowest = i;
            }
            if point.1 > run[highest].1 {
                highest = i;
            }
        }
        let mut indices = [0, lowest, highest, run.len() - 1];
        indices.sort_unstable();
        for (position, &index) in indices.iter().enumerate() {
            if position == 0 || indices[position - 1] != index {
                kept.push(run[index]);
            }
        }
    }
    kept
}

/// Merges dots into horizontal strokes on a grid of `cell` pixels: (from x,
/// until x, y) in pixels. A cloud of any size becomes at most one stroke for
/// every second cell.
pub(crate) fn merge_dots(dots: &[(f64, f64)], cell: f64) -> Vec<(f64, f64, f64)> {
    let mut cells: Vec<(i64, i64)> = dots
        .iter()
        .map(|(x, y)| ((y / cell).round() as i64, (x / cell).round() as i64))
        .collect();
    cells.sort_unstable();
    cells.dedup();
    cells
        .chunk_by(|a, b| a.0 == b.0 && a.1 + 1 == b.1)
        .map(|run| {
            let (first, last) = (run[0], run[run.len() - 1]);
            (
                first.1 as f64 * cell,
                last.1 as f64 * cell,
                first.0 as f64 * cell,
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_column_keeps_its_extremes(
            heights in prop::collection::vec(-1e3..1e3f64, 1..4000), width in 1.0..200.0f64,
        ) {
            let count = heights.len() as f64;
            let points: Vec<_> = heights
                .iter()
                .enumerate()
                .map(|(i, y)| (i as f64 * width / count, *y))
                .collect();
            let kept = decimate(&points);
            prop_assert!(kept.len() as f64 <= 4.0 * (width.floor() + 1.0));
            prop_assert_eq!(kept.first(), points.first());
            prop_assert_eq!(kept.last(), points.last());
            for column in 0..=(width as i64) {
                let range = |p: &[(f64, f64)]| crate::axis::extent(
                    p.iter().filter(|p| p.0.floor() as i64 == column).map(|p| p.1),
                );
                prop_assert_eq!(range(&kept), range(&points));
            }
            // Nothing is invented and the order is kept.
            let mut rest = points.iter();
            for point in &kept {
                prop_assert!(rest.any(|p| p == point));
            }
        }

        #[test]
        fn merged_dots_cover_every_dot(
            dots in prop::collection::vec((0.0..100.0f64, 0.0..100.0f64), 0..500),
        ) {
            let strokes = merge_dots(&dots, 2.0);
            for (x, y) in &dots {
                let covered = strokes.iter().any(|(from, until, at)| {
                    (y - at).abs() <= 1.0 && *x >= from - 1.0 && *x <= until + 1.0
                });
                prop_assert!(covered);
            }
        }
    }
}
