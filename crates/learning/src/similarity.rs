//! Whether two images show the same view: a test that allows for the noise of the camera.
//!
//! A robot that is stuck sees the same view again and again, but no camera takes the same image
//! twice. The noise is estimated from a single image: where the scene is plain, horizontally
//! adjacent pixels differ by noise alone. Images without noise, as the simulator renders them by
//! default, may differ by a mean square of 2 levels at most.

use task::Image;

/// The range of grey levels whose noise is measured. Outside it, noise may be
/// clipped at 0 or 255.
const UNCLIPPED: std::ops::RangeInclusive<u8> = 24..=231;

/// Ratio of the limit on the mean squared difference between two images to the noise estimate.
///
/// With Gaussian noise of variance s^2, two images of the same view have a mean squared difference
/// of 2 s^2 with a standard deviation of 7 %, and the noise estimate is 0.285 s^2: the mean over
/// the smaller half of squares with mean 2 s^2. The limit is then 1.28 times the expected
/// difference, four standard deviations above it.
const LIMIT_RATIO: f32 = 9.0;

/// The lowest limit on the mean squared difference. Noise of a standard deviation below one level
/// mostly vanishes in the rounding to whole levels and is underestimated.
const ROUNDING: f32 = 2.0;

/// The view that an image shows.
///
/// # Examples
///
/// ```
/// use learning::similarity::View;
/// use task::Image;
///
/// let image = [100; Image::BYTES];
/// let mut other = image;
/// other[0] += 1;
/// assert!(View::new(&image).shows(&other));
///
/// other[0] += 50;
/// assert!(!View::new(&image).shows(&other));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    image: &'a [u8; Image::BYTES],
    /// The largest sum of squared differences, over all bytes, to another image of the same view.
    limit: u32,
}

impl View<'_> {
    /// Creates the view of an image, whose bytes have the shape `[7, 20, 3]`.
    pub fn new(image: &[u8; Image::BYTES]) -> View<'_> {
        let mean = (LIMIT_RATIO * noise(image)).max(ROUNDING);
        View { image, limit: (mean * Image::BYTES as f32) as u32 }
    }

    /// Returns whether another image shows the same view, up to the noise of this image.
    #[inline]
    pub fn shows(&self, other: &[u8; Image::BYTES]) -> bool {
        const ROW: usize = Image::WIDTH * Image::CHANNELS;
        let (rows, _) = self.image.as_chunks::<ROW>();
        let (others, _) = other.as_chunks::<ROW>();
        let mut sum = 0;
        rows.iter().zip(others).all(|(row, other)| {
            sum += squared_distance(row, other);
            sum <= self.limit
        })
    }
}

/// Returns the sum of the squared differences between the bytes of two rows.
fn squared_distance<const N: usize>(a: &[u8; N], b: &[u8; N]) -> u32 {
    a.iter().zip(b).map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2)).sum()
}

/// Estimates the noise of an image in squared grey levels: the mean of the smaller half of the
/// squared differences between horizontally adjacent pixels, in each channel. The larger half
/// contains the edges of the scene.
fn noise(image: &[u8; Image::BYTES]) -> f32 {
    let mut counts = [0usize; 256];
    for row in image.chunks_exact(Image::WIDTH * Image::CHANNELS) {
        for (left, right) in row.iter().zip(&row[Image::CHANNELS..]) {
            if UNCLIPPED.contains(left) && UNCLIPPED.contains(right) {
                counts[usize::from(left.abs_diff(*right))] += 1;
            }
        }
    }
    let half = counts.iter().sum::<usize>() / 2;
    let (mut left, mut sum) = (half, 0);
    for (difference, count) in counts.into_iter().enumerate() {
        let taken = count.min(left);
        sum += difference * difference * taken;
        left -= taken;
    }
    sum as f32 / half.max(1) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use task::Random;

    /// A scene with plain areas and edges, with Gaussian noise of the given standard deviation.
    fn image(sigma: f64, random: &mut Random) -> [u8; Image::BYTES] {
        std::array::from_fn(|index| {
            let (pixel, channel) = (index / Image::CHANNELS, index % Image::CHANNELS);
            let (row, column) = (pixel / Image::WIDTH, pixel % Image::WIDTH);
            let level = match (row, column) {
                (..2, _) => 178.0,
                (2..5, 6..9) => [0.0, 200.0, 0.0][channel],
                (2..5, _) => [0.0, 0.0, 150.0][channel],
                _ => 128.0,
            };
            // The sum of twelve uniform numbers is close to normal, with variance 1.
            let normal = (0..12).map(|_| random.uniform()).sum::<f64>() - 6.0;
            (level + sigma * normal).round() as u8
        })
    }

    #[test]
    fn images_of_one_view_are_the_same_at_any_noise_level() {
        let mut random = Random::from_key([3; 4]);
        for sigma in [0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0] {
            let images: Vec<_> = (0..40).map(|_| image(sigma, &mut random)).collect();
            let pairs = images.iter().flat_map(|a| images.iter().map(move |b| (a, b)));
            let same = pairs.filter(|(a, b)| View::new(a).shows(b)).count();
            assert!(same >= 1552, "sigma {sigma}: {same} of 1,600 pairs");
        }
    }

    #[test]
    fn a_view_that_is_shifted_by_a_pixel_is_another_view() {
        let mut random = Random::from_key([4; 4]);
        for sigma in [0.0, 2.0, 5.0, 10.0] {
            let (first, second) = (image(sigma, &mut random), image(sigma, &mut random));
            let mut shifted = second;
            shifted.copy_within(..Image::BYTES - Image::CHANNELS, Image::CHANNELS);
            assert!(!View::new(&first).shows(&shifted), "sigma {sigma}");
        }
    }

    #[test]
    fn a_plain_image_has_no_noise_and_clipped_levels_are_ignored() {
        assert_eq!(noise(&[0; Image::BYTES]), 0.0);
        assert_eq!(noise(&[100; Image::BYTES]), 0.0);
        let clipped = std::array::from_fn(|index| if index % 2 == 0 { 255 } else { 232 });
        assert_eq!(noise(&clipped), 0.0);
    }
}
