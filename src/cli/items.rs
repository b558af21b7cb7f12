//! The items of a batch: files, or the parts of one file.

use crate::args::ReadingArgs;
use crate::exit::Usage;
use crate::options::{Source, hex_sha256, reading};
use crate::output;
use anyhow::Result;
use morpho_fit::dataset::{Dataset, Part, SplitBy, read_csv, split_csv};
use std::collections::{HashMap, HashSet};
use std::path::{Component, Path, PathBuf};

/// Bytes of a folder's name at most, but for a number behind it.
const LONGEST: usize = 100;

/// One measurement that is fitted by itself.
#[derive(Debug)]
pub(crate) struct Item {
    pub(crate) name: String,
    /// Where it lies in a map.
    pub(crate) place: Option<[f64; 2]>,
    /// The file as it was named, for messages.
    pub(crate) file: String,
    data: Data,
}

#[derive(Debug)]
enum Data {
    /// Read when it is its turn.
    File(PathBuf),
    /// Standard input, which can be read once.
    Bytes(Vec<u8>),
    Part(Part),
}

impl Item {
    /// Hash of the data as they lie there; none if they cannot be read.
    pub(crate) fn sha256(&self) -> Option<String> {
        match &self.data {
            Data::File(path) => output::read(path).ok().map(|bytes| hex_sha256(&bytes)),
            Data::Bytes(bytes) => Some(hex_sha256(bytes)),
            Data::Part(part) => Some(part.sha256().to_owned()),
        }
    }

    /// The data, and the hash of the file where they are not read from its very bytes.
    pub(crate) fn read(&self, args: &ReadingArgs) -> Result<(Dataset, Option<String>)> {
        let in_file = |findings: morpho_fit::dataset::Findings| findings.in_file(&self.file);
        let source = match &self.data {
            Data::Part(part) => return Ok((part.read().map_err(in_file)?, None)),
            Data::File(path) => Source::read(path, args)?,
            Data::Bytes(bytes) => Source::of(self.file.clone(), bytes.clone(), args)?,
        };
        Ok((read_csv(&source.bytes, &reading(args)).map_err(in_file)?, source.sha256))
    }
}

/// What `--by` says; none if each file is an item.
pub(crate) fn split_by(columns: &[String]) -> Result<Option<SplitBy>, Usage> {
    let columns: Vec<&str> = columns.iter().map(|name| name.trim()).collect();
    match *columns.as_slice() {
        [] => Ok(None),
        [x, y] if x == y => Err(Usage(format!("--by {x},{y}: the two columns of a map are different ones"))),
        _ if columns.contains(&"") => Err(Usage("--by: the name of a column is empty".to_owned())),
        [name] => Ok(Some(SplitBy::Column(name.to_owned()))),
        [x, y] => Ok(Some(SplitBy::Place([x.to_owned(), y.to_owned()]))),
        _ => Err(Usage("--by takes one column, or two for a map".to_owned())),
    }
}

/// Each file as an item.
pub(crate) fn files(paths: &[PathBuf]) -> Result<Vec<Item>> {
    if let Some(folder) = paths.iter().find(|path| path.is_dir()) {
        let folder = folder.display();
        return Err(Usage(format!("{folder} is a folder; name the files in it, such as {folder}/*.csv")).into());
    }
    let item = |(path, name): (&PathBuf, String)| {
        let is_stream = path == Path::new("-");
        let file = if is_stream { "stdin".to_owned() } else { path.display().to_string() };
        let data = if is_stream { Data::Bytes(output::read(path)?) } else { Data::File(path.clone()) };
        Ok(Item { name, place: None, file, data })
    };
    paths.iter().zip(names(paths)?).map(item).collect()
}

/// The parts of one file.
pub(crate) fn parts(path: &Path, args: &ReadingArgs, by: &SplitBy) -> Result<Vec<Item>> {
    let Source { file, bytes, .. } = Source::read(path, args)?;
    let parts = split_csv(&bytes, &reading(args), by).map_err(|findings| findings.in_file(&file))?;
    let item = |part: Part| Item {
        name: part.name().to_owned(),
        place: part.place(),
        file: file.clone(),
        data: Data::Part(part),
    };
    Ok(parts.into_iter().map(item).collect())
}

/// The names of files without folder and ending; where two are alike, with as many folders as it takes, or the ending.
fn names(paths: &[PathBuf]) -> Result<Vec<String>, Usage> {
    let folders: Vec<Vec<String>> = paths.iter().map(|path| folders(path)).collect();
    let stem = |path: &PathBuf| match path.to_str() {
        Some("-") => "stdin".to_owned(),
        _ => path.file_stem().map_or("data".into(), |stem| stem.to_string_lossy()).into_owned(),
    };
    let mut ends: Vec<String> = paths.iter().map(stem).collect();
    let mut depths = vec![0; paths.len()];
    loop {
        let name = |(end, (folders, &depth)): (&String, (&Vec<String>, &usize))| {
            let above = folders.iter().skip(folders.len().saturating_sub(depth)).cloned();
            above.chain([end.clone()]).collect::<Vec<String>>().join("/")
        };
        let found: Vec<String> = ends.iter().zip(folders.iter().zip(&depths)).map(name).collect();
        let mut count: HashMap<&str, usize> = HashMap::new();
        for name in &found {
            *count.entry(name).or_default() += 1;
        }
        let twice = |index: &usize| found.get(*index).and_then(|name| count.get(name.as_str())).is_some_and(|&n| n > 1);
        let twice: Vec<usize> = (0..paths.len()).filter(twice).collect();
        let mut changed = false;
        for &index in &twice {
            if depths[index] < folders[index].len() {
                depths[index] += 1;
                changed = true;
            }
        }
        if twice.is_empty() {
            return Ok(found);
        }
        // Only the ending can tell them apart then.
        let by_ending = if changed { &[][..] } else { &twice };
        for &index in by_ending {
            let whole = paths[index].file_name().map(|name| name.to_string_lossy().into_owned());
            if let Some(whole) = whole.filter(|whole| *whole != ends[index]) {
                ends[index] = whole;
                changed = true;
            }
        }
        if let (false, Some(&index)) = (changed, twice.first()) {
            return Err(Usage(format!("{} is given twice", paths[index].display())));
        }
    }
}

fn folders(path: &Path) -> Vec<String> {
    let folder = path.parent().into_iter().flat_map(Path::components);
    let name = |component: Component<'_>| match component {
        Component::Normal(name) => Some(name.to_string_lossy().into_owned()),
        Component::ParentDir => Some("..".to_owned()),
        _ => None,
    };
    folder.filter_map(name).collect()
}

/// A folder for each item, named by it as far as file systems allow, all different and none of them a name in `taken`.
pub(crate) fn folder_names(items: &[Item], taken: &[String]) -> Vec<String> {
    let mut used: HashSet<String> = taken.iter().map(|name| name.to_lowercase()).collect();
    let mut numbers: HashMap<String, usize> = HashMap::new();
    let one = |item: &Item| {
        let allowed = |letter: char| letter.is_alphanumeric() || " -_.,+=()".contains(letter);
        let letters = item.name.chars().map(|letter| if allowed(letter) { letter } else { '_' });
        let within = |bytes: &mut usize, letter: char| {
            *bytes += letter.len_utf8();
            (*bytes <= LONGEST).then_some(letter)
        };
        let name: String = letters.scan(0, within).collect();
        let name = name.trim_matches([' ', '.']);
        let name = if name.is_empty() { "item" } else { name };
        let mut free = name.to_owned();
        let number = numbers.entry(name.to_lowercase()).or_insert(1);
        while !used.insert(free.to_lowercase()) {
            *number += 1;
            free = format!("{name} {number}");
        }
        free
    };
    items.iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(paths: &[&str]) -> Result<Vec<String>, String> {
        let paths: Vec<PathBuf> = paths.iter().map(PathBuf::from).collect();
        names(&paths).map_err(|problem| problem.0)
    }

    #[test]
    fn files_have_the_shortest_names_that_differ() {
        assert_eq!(of(&["a/left.csv", "right.csv"]).unwrap(), ["left", "right"]);
        assert_eq!(of(&["a/x.csv", "b/x.csv", "c/y.csv"]).unwrap(), ["a/x", "b/x", "y"]);
        assert_eq!(of(&["a/1/x.csv", "b/1/x.csv", "x.csv"]).unwrap(), ["a/1/x", "b/1/x", "x"]);
        assert_eq!(of(&["../x.csv", "x.csv", "-"]).unwrap(), ["../x", "x", "stdin"]);
        assert_eq!(of(&["x.csv", "x.txt"]).unwrap(), ["x.csv", "x.txt"]);
        assert!(of(&["x.csv", "y.csv", "./x.csv"]).unwrap_err().contains("x.csv is given twice"));
    }

    #[test]
    fn every_item_has_a_folder_of_its_own_below_the_results() {
        let item = |name: &str| Item {
            name: name.to_owned(),
            place: None,
            file: String::new(),
            data: Data::Bytes(Vec::new()),
        };
        let items = ["a/x", "a_x", "..", "../y", "Batch.csv", "1,2"].map(item);
        let folders = folder_names(&items, &["batch.csv".to_owned()]);
        assert_eq!(folders, ["a_x", "a_x 2", "item", "_y", "Batch.csv 2", "1,2"]);
        // A letter may have three bytes; file systems count those. Names with a number come after those that have it.
        let long = "鱗".repeat(120);
        let folders = folder_names(&[long.as_str(), &long, "a 2", "a", "a", "a"].map(item), &[]);
        assert_eq!(folders[0], "鱗".repeat(33));
        assert_eq!(folders[1], format!("{} 2", folders[0]));
        assert_eq!(folders[2..], ["a 2", "a", "a 3", "a 4"]);
    }

    #[test]
    fn one_column_splits_and_two_make_a_map() {
        let by = |text: &str| split_by(&text.split(',').map(str::to_owned).collect::<Vec<_>>());
        assert_eq!(by("pixel").unwrap(), Some(SplitBy::Column("pixel".to_owned())));
        assert_eq!(by("x, y").unwrap(), Some(SplitBy::Place(["x".to_owned(), "y".to_owned()])));
        assert_eq!(split_by(&[]).unwrap(), None);
        for wrong in ["x,x", "x,", "x,y,z"] {
            assert!(by(wrong).is_err(), "{wrong}");
        }
    }
}
