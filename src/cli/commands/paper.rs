//! `morpho-fit paper`: the paper's figures and table, as printed and right.

use crate::args::PaperArgs;
use crate::commands::{chart_files, drawn};
use crate::exit::{Outcome, Usage};
use crate::output::{self, Folder, WIDTH};
use anyhow::Result;
use morpho_fit::report::paper::{TITLE, page};
use morpho_fit::report::terminal;

pub(crate) fn run(args: &PaperArgs) -> Result<Outcome> {
    let text = args.out.join("README.md");
    if text.exists() && !output::read(&text)?.starts_with(TITLE.as_bytes()) {
        return Err(Usage(format!(
            "{} is not of this command and would be replaced; give another --out",
            text.display()
        ))
        .into());
    }
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
        let written = format!("{}: {}", folder.path().display(), names.join(" "));
        output::print(terminal::wrapped(&written, "", "  ", WIDTH).as_bytes())?;
    }
    Ok(Outcome::Done)
}
