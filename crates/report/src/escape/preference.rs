//! What the robot would rather do: the softmax of the Q-values, on the compass of its turns.

use task::Action;

use super::colour_scale::ColourScale;
use super::colours::{GRID, INK, MUTED};
use super::drawing::Drawing;
use crate::numbers::decimal;

/// The temperature of the softmax, in the unit of the reward: 0.1 is what a step costs, so an action
/// that costs one step more is preferred e times less. At a temperature of 1 the actions would look
/// alike.
pub const TEMPERATURE: f64 = 0.1;

/// Half the angle that an action's sector takes, in degrees: there is a gap between neighbours.
const HALF_WIDTH: f64 = 19.0;

/// A polar plot, ahead being up, left being left.
pub(super) struct Compass {
    /// Where its middle is on the page, in pixels.
    pub centre: (f64, f64),
    /// The radius of the outermost ring, in pixels. The coloured rim and the labels lie beyond.
    pub radius: f64,
    /// The probability that reaches to the outermost ring.
    pub full: f64,
    /// The colours of the Q-values.
    pub scale: ColourScale,
}

/// The preference for each action: `exp(value / TEMPERATURE)`, in shares of their sum. What is not
/// a number has none; where nothing is a number, all are alike.
pub(super) fn softmax(values: &[f32; Action::COUNT]) -> [f64; Action::COUNT] {
    let values = values.map(|value| if value.is_nan() { f64::NEG_INFINITY } else { value.into() });
    let greatest = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let weights = values.map(|value| {
        // Infinity less infinity is not a number, but is no distance.
        if value == greatest { 1.0 } else { ((value - greatest) / TEMPERATURE).exp() }
    });
    let sum: f64 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}

/// The smallest of 20, 40, 60, 80 and 100 % that holds every preference.
pub(super) fn full_ring<'a>(values: impl IntoIterator<Item = &'a [f32; Action::COUNT]>) -> f64 {
    let greatest = values.into_iter().flat_map(softmax).fold(0.0, f64::max);
    [0.2, 0.4, 0.6, 0.8].into_iter().find(|ring| greatest <= *ring).unwrap_or(1.0)
}

impl Compass {
    /// Draws the preferences as sectors, the colours of the values on them and on the rim, and a
    /// line around the action that was taken.
    pub fn draw(&self, drawing: &mut Drawing, values: &[f32; Action::COUNT], taken: Action) {
        let (x, y) = self.centre;
        let radius = self.radius;
        let attributes = format_args!("class='preference' transform='translate({x:.1} {y:.1})'");
        drawing.group(attributes, |drawing| {
            for ring in [radius, radius / 2.0] {
                drawing.add(format_args!(
                    "<circle r='{ring:.1}' fill='none' stroke='{GRID}' stroke-width='1.2'/>"
                ));
            }
            // The action taken comes last, so that no neighbour covers its line.
            let others = Action::ALL.into_iter().filter(|action| *action != taken);
            for action in others.chain([taken]) {
                let index = usize::from(action.index());
                let colour = self.scale.colour(values[index]);
                let length = radius * (softmax(values)[index] / self.full).min(1.0);
                let line = if action == taken { INK } else { "none" };
                drawing.add(format_args!(
                    "<path d='{}' fill='{colour}'/>\
                     <path class='action' d='{}' fill='{colour}' stroke='{line}' \
                     stroke-width='2.2' stroke-linejoin='round'/>",
                    sector(action, radius + 5.0, radius + 11.0),
                    sector(action, 0.0, length),
                ));
            }
        });
    }

    /// Writes the turns around the rim, that of the action taken in bold, and the preferences that
    /// the rings stand for where the robot cannot turn.
    pub fn label(&self, drawing: &mut Drawing, taken: Action) {
        let (x, y) = self.centre;
        for action in Action::ALL {
            let (right, down) = direction(f64::from(action.turn_degrees()));
            let weight = if action == taken {
                format!("font-weight='700' fill='{INK}'")
            } else {
                format!("fill='{MUTED}'")
            };
            let attributes = format!("font-size='13' text-anchor='middle' {weight}");
            // Words are wider than they are high.
            let place = (x + right * (self.radius + 34.0), y + down * (self.radius + 23.0) + 4.5);
            let words = format!("{}°", decimal(action.turn_degrees().into(), 0));
            drawing.text(place, &attributes, words);
        }
        for share in [0.5, 1.0] {
            let attributes = format!("font-size='11' text-anchor='middle' fill='{MUTED}'");
            let words = format!("{}\u{a0}%", decimal(100.0 * share * self.full, 0));
            drawing.text((x, y + share * self.radius + 4.0), &attributes, words);
        }
    }
}

/// The way an angle points on the page, in degrees counter-clockwise from straight ahead, as a
/// vector of length 1: (right, down).
fn direction(degrees: f64) -> (f64, f64) {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    (-sine, -cosine)
}

/// The piece of an action between two radii, as a closed path.
fn sector(action: Action, inner: f64, outer: f64) -> String {
    let turn = f64::from(action.turn_degrees());
    let [right, left] = [turn - HALF_WIDTH, turn + HALF_WIDTH].map(direction);
    let at = |(x, y): (f64, f64), radius: f64| format!("{:.2} {:.2}", x * radius, y * radius);
    let back = if inner > 0.0 {
        format!("L{}A{inner:.2} {inner:.2} 0 0 1 {}Z", at(left, inner), at(right, inner))
    } else {
        "L0 0Z".to_owned()
    };
    format!("M{}A{outer:.2} {outer:.2} 0 0 0 {}{back}", at(right, outer), at(left, outer))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preferences_are_shares() {
        let cost = TEMPERATURE as f32;
        let shares = softmax(&[-1.0, -1.0 - cost, -9.0, -1.0, -1.0, -1.0, -1e9]);
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!((shares[0] / shares[1] - std::f64::consts::E).abs() < 1e-4);
        assert_eq!(softmax(&[-0.7; 7]), [1.0 / 7.0; 7]);
    }

    #[test]
    fn a_broken_network_has_preferences_too() {
        let mut values = [-1.0; 7];
        values[2] = f32::NAN;
        assert_eq!(softmax(&values)[2], 0.0);
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
            assert_eq!(softmax(&[value; 7]), [1.0 / 7.0; 7]);
        }
    }

    #[test]
    fn the_rings_hold_every_preference() {
        assert_eq!(full_ring(&[[-1.0; 7]]), 0.2);
        assert_eq!(full_ring(&[[-1.0; 7], [0.0, -9.0, -9.0, -9.0, -9.0, -9.0, -9.0]]), 1.0);
        assert_eq!(full_ring(&[]), 0.2);
    }

    #[test]
    fn left_is_left() {
        // Action 5 turns left by 90 degrees.
        let path = sector(Action::try_from(5).unwrap(), 0.0, 100.0);
        assert_eq!(path, "M-94.55 -32.56A100.00 100.00 0 0 0 -94.55 32.56L0 0Z");
    }
}
