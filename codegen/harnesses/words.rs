//! Words of any value within a range, for stubs and harnesses.

/// Any words within ±`limit`.
pub fn any_within<const N: usize>(limit: i32) -> [i32; N] {
    let words: [i32; N] = kani::any();
    for word in words {
        kani::assume((-limit..=limit).contains(&word));
    }
    kani::cover!(words[0] == limit, "at the limit");
    words
}

/// Holds that words are within ±`limit`.
///
/// # Panics
/// If one is not.
pub fn assert_within(words: &[i32], limit: i32) {
    for word in words {
        assert!(
            (-limit..=limit).contains(word),
            "an argument out of its contract"
        );
    }
}
