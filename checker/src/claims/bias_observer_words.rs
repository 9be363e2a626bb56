//! The words of the observer of the angle's bias, checked against its stated numbers
//! ([`crate::claims::bias_observer_numbers`] explains their meaning).
//!
//! All products have p fraction bits. p is the largest number with which a sum of products of any
//! words stays within 64 bits. A number c per unit of a word with q fraction bits is the word
//! c 2^(p − q), rounded.

use num_rational::BigRational;
use num_traits::Signed;

use crate::certificate::reader::{Certificate, CertifiedObserver};
use crate::claims::control_law::EmittedLaw;
use crate::claims::emitted_observer::STATE_BITS;
use crate::claims::named_words::{NamedWords, nearest};
use crate::exact::rational::{exponent, integer, power_of_two};

type Check = Result<(), String>;

/// Most fraction bits of a product.
const PRODUCT_BITS_MAX: i32 = 60;

/// The words of `BIAS_OBSERVER` are the stated numbers, rounded; all nothing where none are stated.
///
/// # Errors
/// A sentence that names the word.
pub(crate) fn check_words(
    certificate: &Certificate,
    law: &EmittedLaw,
    words: &NamedWords,
) -> Check {
    let Some(observer) = &certificate.bias_observer else {
        // Nothing of one is left but shifts that are valid.
        for (name, word) in words.iter() {
            let wanted = i128::from(name.ends_with("_shift"));
            if word != wanted {
                return Err(format!(
                    "{name} is {word} in a module without a bias estimate"
                ));
            }
        }
        return Ok(());
    };
    let angle_bits = exponent(law.state_bits[0]);
    let get = |field: &str| words.get(&format!("BIAS_OBSERVER.{field}"));
    let is = |field: &str, wanted: BigRational| {
        let found = get(field)?;
        if found == wanted {
            Ok(())
        } else {
            Err(format!("BIAS_OBSERVER.{field} is {found}, not {wanted}"))
        }
    };
    let product_bits = (angle_bits.max(STATE_BITS) + 1..=PRODUCT_BITS_MAX)
        .rev()
        .find(|bits| fits(&scaled(observer, law, *bits)))
        .ok_or("the numbers of bias_observer fit no words")?;
    is("unit", power_of_two(product_bits - STATE_BITS))?;
    is("state_shift", integer((product_bits - STATE_BITS).into()))?;
    is("angle_shift", integer((product_bits - angle_bits).into()))?;
    for (field, real) in scaled(observer, law, product_bits) {
        nearest(&format!("BIAS_OBSERVER.{field}"), &get(&field)?, &real)?;
    }
    nearest(
        "BIAS_OBSERVER.limit",
        &get("limit")?,
        &(&observer.limit_rad.value * power_of_two(angle_bits)),
    )
}

/// Each number of the observer in units of its word, for products with `bits` fraction bits.
fn scaled(observer: &CertifiedObserver, law: &EmittedLaw, bits: i32) -> Vec<(String, BigRational)> {
    let unit = |word_bits: i32| power_of_two(bits - word_bits);
    let mut all = vec![("decay".to_owned(), &observer.decay.value * unit(STATE_BITS))];
    for i in 0..3 {
        let state = unit(exponent(law.state_bits[i]));
        all.push((format!("direct[{i}]"), &observer.direct[i].value * &state));
        all.push((
            format!("from_states[{i}]"),
            &observer.from_states[i].value * &state,
        ));
    }
    all.push((
        "from_current".to_owned(),
        &observer.from_current.value * unit(exponent(law.current_bits)),
    ));
    // 1, on the same scale as the decay.
    all.push(("unit".to_owned(), unit(STATE_BITS)));
    all
}

/// Whether sums of products with any words, and the half that rounds, stay below 2⁶³.
fn fits(scaled: &[(String, BigRational)]) -> bool {
    let sum = |names: &[&str]| -> BigRational {
        scaled
            .iter()
            .filter(|(name, _)| names.iter().any(|start| name.starts_with(start)))
            .map(|(_, value)| value.abs().round())
            .sum()
    };
    let largest = power_of_two(31);
    sum(&["unit", "direct"]) < largest && sum(&["decay", "from_"]) < largest
}
