//! The action preferences: the softmax of the Q-values as a polar plot over the turns.

use task::Action;

use super::colour_scale::ColourScale;
use super::colours::{GRID, INK, MUTED};
use super::drawing::Drawing;
use crate::numbers::decimal;

/// The temperature of the softmax, in units of the reward.
///
/// A step has the reward -0.1, so at a temperature of 0.1 the preference for an action that costs
/// one more step is smaller by a factor of e. At a temperature of 1, all preferences would look
/// alike.
pub const TEMPERATURE: f64 = 0.1;

/// Half the angle of a sector in degrees. The turns are 45 degrees apart, so gaps remain.
const HALF_WIDTH: f64 = 19.0;

/// A polar plot of action preferences. Straight ahead points up; a left turn points to the left.
pub(super) struct PolarPlot {
    /// Centre in pixels.
    pub centre: (f64, f64),
    /// Radius of the outer ring in pixels. The coloured rim and the turn labels are outside it.
    pub radius: f64,
    /// Preference that reaches the outer ring.
    pub full: f64,
    /// Colour scale of the Q-values.
    pub scale: ColourScale,
}

/// Returns the preference for each action: `exp(value / TEMPERATURE)`, divided by the sum over all
/// actions. The preference for a NaN value is 0; if all values are NaN, all preferences are equal.
pub(super) fn softmax(values: &[f32; Action::COUNT]) -> [f64; Action::COUNT] {
    let values = values.map(|value| if value.is_nan() { f64::NEG_INFINITY } else { value.into() });
    let largest = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let weights = values.map(|value| {
        // Avoids infinity - infinity, which is NaN.
        if value == largest { 1.0 } else { ((value - largest) / TEMPERATURE).exp() }
    });
    let sum: f64 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}

/// Returns the smallest of 0.2, 0.4, 0.6, 0.8 and 1 that is not below any preference.
pub(super) fn full_ring<'a>(values: impl IntoIterator<Item = &'a [f32; Action::COUNT]>) -> f64 {
    let largest = values.into_iter().flat_map(softmax).fold(0.0, f64::max);
    [0.2, 0.4, 0.6, 0.8].into_iter().find(|ring| largest <= *ring).unwrap_or(1.0)
}

impl PolarPlot {
    /// Draws the preferences as sectors in the colours of the Q-values, a rim in the same colours,
    /// and an outline around the selected action.
    pub fn draw(&self, drawing: &mut Drawing, values: &[f32; Action::COUNT], selected: Action) {
        let (x, y) = self.centre;
        let radius = self.radius;
        let attributes = format_args!("class='preference' transform='translate({x:.1} {y:.1})'");
        drawing.group(attributes, |drawing| {
            for ring in [radius, radius / 2.0] {
                drawing.add(format_args!(
                    "<circle r='{ring:.1}' fill='none' stroke='{GRID}' stroke-width='1.2'/>"
                ));
            }
            // The selected action is drawn last, so that no other sector covers its outline.
            let others = Action::ALL.into_iter().filter(|action| *action != selected);
            for action in others.chain([selected]) {
                let index = usize::from(action.index());
                let colour = self.scale.colour(values[index]);
                let length = radius * (softmax(values)[index] / self.full).min(1.0);
                let outline = if action == selected { INK } else { "none" };
                drawing.add(format_args!(
                    "<path d='{}' fill='{colour}'/>\
                     <path class='action' d='{}' fill='{colour}' stroke='{outline}' \
                     stroke-width='2.2' stroke-linejoin='round'/>",
                    sector(action, radius + 5.0, radius + 11.0),
                    sector(action, 0.0, length),
                ));
            }
        });
    }

    /// Labels the turns around the rim, with the selected action in bold. Labels the rings with
    /// their preferences at the bottom, where there is no action.
    pub fn label(&self, drawing: &mut Drawing, selected: Action) {
        let (x, y) = self.centre;
        for action in Action::ALL {
            let (right, down) = direction(f64::from(action.turn_degrees()));
            let weight = if action == selected {
                format!("font-weight='700' fill='{INK}'")
            } else {
                format!("fill='{MUTED}'")
            };
            let attributes = format!("font-size='13' text-anchor='middle' {weight}");
            // Labels are wider than they are tall, so their horizontal distance is larger.
            let at = (x + right * (self.radius + 34.0), y + down * (self.radius + 23.0) + 4.5);
            let label = format!("{}°", decimal(action.turn_degrees().into(), 0));
            drawing.text(at, &attributes, label);
        }
        for share in [0.5, 1.0] {
            let attributes = format!("font-size='11' text-anchor='middle' fill='{MUTED}'");
            let label = format!("{}\u{a0}%", decimal(100.0 * share * self.full, 0));
            drawing.text((x, y + share * self.radius + 4.0), &attributes, label);
        }
    }
}

/// Returns the direction of an angle on the page as a unit vector (right, down). The angle is in
/// degrees, counter-clockwise from straight ahead.
fn direction(degrees: f64) -> (f64, f64) {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    (-sine, -cosine)
}

/// Returns the sector of an action between two radii, in pixels, as SVG path data.
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
    fn preferences_sum_to_one() {
        let cost = TEMPERATURE as f32;
        let shares = softmax(&[-1.0, -1.0 - cost, -9.0, -1.0, -1.0, -1.0, -1e9]);
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!((shares[0] / shares[1] - std::f64::consts::E).abs() < 1e-4);
        assert_eq!(softmax(&[-0.7; 7]), [1.0 / 7.0; 7]);
    }

    #[test]
    fn non_finite_and_extreme_values_have_preferences() {
        let mut values = [-1.0; 7];
        values[2] = f32::NAN;
        assert_eq!(softmax(&values)[2], 0.0);
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
            assert_eq!(softmax(&[value; 7]), [1.0 / 7.0; 7]);
        }
    }

    #[test]
    fn the_outer_ring_covers_every_preference() {
        assert_eq!(full_ring(&[[-1.0; 7]]), 0.2);
        assert_eq!(full_ring(&[[-1.0; 7], [0.0, -9.0, -9.0, -9.0, -9.0, -9.0, -9.0]]), 1.0);
        assert_eq!(full_ring(&[]), 0.2);
    }

    #[test]
    fn a_left_turn_points_to_the_left() {
        // Action 5 turns left by 90 degrees.
        let path = sector(Action::try_from(5).unwrap(), 0.0, 100.0);
        assert_eq!(path, "M-94.55 -32.56A100.00 100.00 0 0 0 -94.55 32.56L0 0Z");
    }
}
