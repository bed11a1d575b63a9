//! Sorting by a number, and the median. One sort serves items of every type: sorting compiled for each type
//! took a tenth of the WebAssembly module that the page loads.

/// Sorts items by a number in ascending order; items with equal numbers keep their order.
pub fn sort_by_number<T>(items: &mut [T], number: impl FnMut(&T) -> f64) {
    let mut sources = in_order(items.iter().map(number).collect());
    for place in 0..items.len() {
        // The item that was here has moved to where the item that belongs here came from.
        let mut source = sources[place];
        while source < place {
            source = sources[source];
        }
        sources[place] = source;
        items.swap(place, source);
    }
}

/// Returns the value at half of the weights of `(value, weight)`; `None` without values.
pub fn weighted_median(mut values: Vec<(f64, f64)>) -> Option<f64> {
    sort_by_number(&mut values, |one| one.0);
    let half = 0.5 * values.iter().map(|one| one.1).sum::<f64>();
    let mut sum = 0.0;
    let at_half = values.iter().find(|one| {
        sum += one.1;
        half <= sum
    });
    at_half.map(|one| one.0)
}

/// Returns the indices of the numbers in ascending order of the numbers.
fn in_order(numbers: Vec<f64>) -> Vec<usize> {
    let mut places: Vec<usize> = (0..numbers.len()).collect();
    places.sort_by(|a, b| numbers[*a].total_cmp(&numbers[*b]));
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_weights_lie_on_each_side_of_the_median() {
        assert_eq!(weighted_median(vec![(3.0, 1.0), (1.0, 1.0), (2.0, 1.0)]), Some(2.0));
        assert_eq!(weighted_median(vec![(3.0, 5.0), (1.0, 1.0), (2.0, 1.0)]), Some(3.0));
        assert_eq!(weighted_median(vec![(3.0, 1.0), (1.0, 9.0), (f64::INFINITY, 1.0)]), Some(1.0));
        assert_eq!(weighted_median(Vec::new()), None);
    }

    #[test]
    fn it_orders_as_a_stable_sort_does() {
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        for length in 0..200 {
            let mut items: Vec<(f64, usize)> = Vec::new();
            for index in 0..length {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                items.push((
                    [f64::NAN, f64::INFINITY, -0.0, 0.0, 1.0, -1.0, 2.5][(state % 7) as usize],
                    index,
                ));
            }
            for sign in [1.0, -1.0] {
                let mut expected = items.clone();
                expected.sort_by(|a, b| (sign * a.0).total_cmp(&(sign * b.0)));
                sort_by_number(&mut items, |item| sign * item.0);
                let places = |all: &[(f64, usize)]| all.iter().map(|item| item.1).collect::<Vec<_>>();
                assert_eq!(places(&items), places(&expected));
            }
        }
    }
}
