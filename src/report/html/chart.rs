//! Pictures of the page.

use super::markup::{element, escape, scrolled};

/// Share of its size down to which the texts of a picture can be read; a narrower box scrolls.
const READABLE: f64 = 0.55;

/// A picture with what a reader should see in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chart<'a> {
    /// What it shows, in a few words.
    pub heading: String,
    /// One sentence: what to look at.
    pub caption: String,
    /// An SVG document, trusted as it is.
    pub svg: &'a str,
}

impl<'a> Chart<'a> {
    /// The chart that a fit leaves under this name (`curves`, `residuals`, `atlas`, `sweep`, `profile`, `corner`, `trace`) with
    /// its caption; any other name becomes the heading, without a caption.
    ///
    /// ```
    /// use morpho_fit::report::html::Chart;
    /// let chart = Chart::named("atlas", "<svg xmlns=\"http://www.w3.org/2000/svg\"/>");
    /// assert_eq!(chart.heading, "Map of chi² over the two thicknesses");
    /// ```
    #[must_use]
    pub fn named(name: &str, svg: &'a str) -> Self {
        let (heading, caption) = match name {
            "curves" => (
                "Data and model",
                "Points are the readings, with error bars where sigma is stated; the line is the model, and dashed lines are \
                 its parts where there are several.",
            ),
            "residuals" => (
                "Residuals",
                "Data less model in standard deviations: of plain noise 95 of 100 points lie in the grey band, without \
                 waves or slopes.",
            ),
            "atlas" => (
                "Map of chi² over the two thicknesses",
                "Yellow fits well, dark does not; the black outline encloses what fits as well as the best, and the numbers \
                 are the minima that the search found.",
            ),
            "sweep" => (
                "Colour against the gap",
                "The colour in the mirror direction along the ridges as the gap changes and the period stays, and the \
                 reflectivity at normal incidence; the upright lines are the fit and the ends of its 95 % interval.",
            ),
            "profile" => (
                "Profile likelihood",
                "Each quantity is held at a value and all others are fitted again: its intervals end where chi² crosses \
                 the levels, and the dashed line is the parabola of the covariance.",
            ),
            "corner" => (
                "Posterior",
                "Samples of the parameters singly and in pairs: a narrow slanted cloud is a pair that only its combination \
                 tells; the lines are the best fit and the middle 68 %.",
            ),
            "trace" => (
                "Chains of the sampler",
                "Values step by step after the warm-up: the chains should lie over one another and not drift.",
            ),
            other => (other, ""),
        };
        Self { heading: heading.to_owned(), caption: caption.to_owned(), svg }
    }

    /// The picture inline, in a box that scrolls where the screen is too narrow to read it.
    pub(super) fn figure(&self) -> String {
        // A declaration before the picture's own element may stand in a file, not in a page.
        let Some((_, rest)) = self.svg.split_once("<svg") else { return String::new() };
        let heading = escape(&self.heading);
        let least =
            own_width(rest).map(|width| format!(" style=\"--least:{:.0}px\"", READABLE * width)).unwrap_or_default();
        let svg = format!("<svg role=\"img\" aria-label=\"{heading}\"{least}{}\n", rest.trim_end());
        let caption = if self.caption.is_empty() { String::new() } else { format!(" {}", escape(&self.caption)) };
        let caption = format!("<figcaption><b>{heading}.</b>{caption}</figcaption>\n");
        format!("<figure>\n{caption}{}</figure>\n", scrolled("chart", &self.heading, &svg))
    }
}

/// The width that an opening tag states, in pixels.
fn own_width(tag: &str) -> Option<f64> {
    let (tag, _) = tag.split_once('>')?;
    let (_, width) = tag.split_once(" width=\"")?;
    width.split_once('"')?.0.parse().ok().filter(|width: &f64| width.is_finite() && *width > 0.0)
}

/// A colour to show, such as that of the fitted layers under daylight.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Swatch {
    /// What has the colour.
    pub name: String,
    /// Encoded sRGB: red, green, blue.
    pub colour: [u8; 3],
    /// What belongs to it, such as light and observer.
    pub note: String,
}

impl Swatch {
    /// A square with its name and note.
    pub(super) fn item(&self) -> String {
        let [red, green, blue] = self.colour;
        let square = format!("<span class=\"swatch\" style=\"background:#{red:02x}{green:02x}{blue:02x}\"></span>");
        let name = element("b", &self.name);
        format!("<li>{square}\n<span>{name}{}</span></li>\n", escape(&self.note))
    }
}
