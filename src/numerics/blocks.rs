//! Blocks of a list that go through vector code together.

/// `N` values from `first` on, or as many as there are and zeros.
#[inline(always)]
pub(crate) fn padded<const N: usize>(list: &[f64], first: usize) -> [f64; N] {
    // A whole block is copied without a call.
    if let Some(Ok(whole)) = list.get(first..first + N).map(<&[f64; N]>::try_from) {
        return *whole;
    }
    let mut block = [0.0; N];
    block[..list.len() - first].copy_from_slice(&list[first..]);
    block
}

/// Writes a block from `first` on, or as much of it as there is room for.
#[inline(always)]
pub(crate) fn put<T: Copy, const N: usize>(block: &[T; N], out: &mut [T], first: usize) {
    if let Some(Ok(whole)) = out.get_mut(first..first + N).map(<&mut [T; N]>::try_from) {
        *whole = *block;
        return;
    }
    let rest = &mut out[first..];
    rest.copy_from_slice(&block[..rest.len()]);
}

#[cfg(test)]
mod tests {
    use super::{padded, put};

    #[test]
    fn a_list_goes_through_blocks_and_back() {
        for length in [1_usize, 3, 4, 7, 8] {
            let list: Vec<f64> = (1..=length).map(|i| i as f64).collect();
            let mut back = vec![0.0; length];
            for first in (0..length).step_by(4) {
                let block = padded::<4>(&list, first);
                assert!(block.iter().skip(length - first).all(|value| *value == 0.0));
                put(&block, &mut back, first);
            }
            assert_eq!(back, list);
        }
    }
}
