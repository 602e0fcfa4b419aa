//! Comparing a field from the device with its reference.

/// Asserts that `got` is within `tolerance` of `want` everywhere; says where it is not, and by how much.
#[track_caller]
pub fn assert_close(name: &str, got: &[f32], want: &[f64], tolerance: f64) {
    if let Err(message) = check_close(got, want, tolerance) {
        panic!("{name}: {message}");
    }
}

/// As [`assert_close`], as a value.
pub fn check_close(got: &[f32], want: &[f64], tolerance: f64) -> Result<(), String> {
    if got.len() != want.len() {
        return Err(format!("{} values where {} are expected", got.len(), want.len()));
    }
    // A NaN on either side is infinitely wrong.
    let error = |index: &usize| {
        let difference = (f64::from(got[*index]) - want[*index]).abs();
        if difference.is_nan() { f64::INFINITY } else { difference }
    };
    let wrong: Vec<usize> = (0..got.len()).filter(|index| error(index) > tolerance).collect();
    let Some(worst) = wrong.iter().copied().max_by(|i, j| error(i).total_cmp(&error(j))) else {
        return Ok(());
    };
    Err(format!(
        "{} of {} values differ by more than {tolerance:e}; the worst is {} where {} is expected, at {worst}",
        wrong.len(),
        got.len(),
        got[worst],
        want[worst]
    ))
}
