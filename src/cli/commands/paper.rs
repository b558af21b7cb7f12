//! `morpho-fit paper`: the paper's figures and table, as printed and right.

use crate::args::PaperArgs;
use crate::commands::{chart_files, drawn};
use crate::exit::Outcome;
use crate::output::{self, Folder};
use anyhow::Result;
use morpho_fit::report::paper::page;

pub(crate) fn run(args: &PaperArgs) -> Result<Outcome> {
    let folder = Folder::open(&args.out)?;
    let work = || -> Result<Vec<String>> {
        let page = page()?;
        let mut files = vec![
            ("README.md".to_owned(), page.text.into_bytes()),
            ("colours.csv".to_owned(), page.colours.into_bytes()),
        ];
        files.extend(chart_files(&drawn(page.figures)?));
        folder.write(&files)?;
        Ok(files.into_iter().map(|(name, _)| name).collect())
    };
    let names = work().inspect_err(|_| folder.abandon())?;
    if !args.quiet {
        output::print(format!("{}: {}\n", folder.path().display(), names.join(" ")).as_bytes())?;
    }
    Ok(Outcome::Done)
}
