//! The house: which rooms may import which, no circles among files, few files side by side, short functions, no names of effects
//! outside the catalogue, no files and no terminal in rooms that compute.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use fiveaxis::effects::KINDS;

/// Rooms in the order in which they may import: each only from those before it, as the library's own table has them; `verbs` are the
/// program's.
fn rooms() -> Vec<String> {
    let text = std::fs::read_to_string(source().join("lib.rs")).expect("lib.rs");
    let room = |line: &str| Some(line.strip_prefix("//! | [`")?.split_once('`')?.0.to_string());
    let rooms: Vec<String> = text.lines().filter_map(room).chain([String::from("verbs")]).collect();
    assert!(rooms.len() > 20, "{rooms:?}");
    rooms
}

/// Rooms whose files still import each other in circles. A room leaves this list when it has none, and may not come back.
const STILL_IN_CIRCLES: [&str; 0] = [];

/// Most files that may lie side by side in a folder: what a reader takes in at one look.
const MOST_SIDE_BY_SIDE: usize = 16;

/// Folders with one file for each kind of a thing, however many kinds there are.
const ONE_FILE_PER_KIND: [&str; 1] = ["effects"];

/// Folders in which still more files lie side by side. A folder leaves this list when it has fewer, and may not come back.
const STILL_FLAT: [&str; 0] = [];

/// Most lines of a function: what a reader sees at once.
const MOST_LINES: usize = 80;

/// Most parameters of a function, the value that it is called on included.
const MOST_PARAMETERS: usize = 7;

/// Rooms whose inner rooms still import each other in circles. A room leaves this list when they do not, and may not come back.
const STILL_ENTWINED: [&str; 0] = [];

/// Rooms that read and write files, or speak to the terminal.
const WITH_FILES: [&str; 2] = ["load", "verbs"];

/// A file of the library by its module path: `["diagnose", "noise", "spectrum"]`.
type Module = Vec<String>;

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

fn files_in(folder: &Path, list: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        if entry.is_dir() {
            files_in(&entry, list);
        } else if entry.extension().is_some_and(|extension| extension == "rs") {
            list.push(entry);
        }
    }
}

/// Code of every file, without comments and without its own tests.
fn modules() -> BTreeMap<Module, String> {
    let mut files = Vec::new();
    files_in(&source(), &mut files);
    let mut modules = BTreeMap::new();
    for file in files {
        let text = std::fs::read_to_string(&file).expect("source");
        let code = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
        let code: Vec<&str> = code.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
        let inner = file.strip_prefix(source()).expect("inside").with_extension("");
        let mut path: Module = inner.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        if path.last().is_some_and(|last| ["mod", "lib"].contains(&last.as_str())) {
            path.pop();
        }
        modules.insert(path, code.join("\n"));
    }
    modules
}

/// A function as it is written.
#[derive(Debug, PartialEq)]
struct Function {
    name: String,
    lines: usize,
    parameters: usize,
}

/// Functions of a formatted text: each ends with the first brace that stands below its beginning.
fn functions(text: &str) -> Vec<Function> {
    let lines: Vec<&str> = text.lines().collect();
    let mut list = Vec::new();
    for (first, line) in lines.iter().enumerate() {
        let indent = line.len() - line.trim_start().len();
        let mut words = line.split_whitespace().skip_while(|word| word.starts_with("pub") || *word == "const");
        let (Some("fn"), Some(named)) = (words.next(), words.next()) else { continue };
        let is_name = |letter: char| letter.is_alphanumeric() || letter == '_';
        let name: String = named.chars().take_while(|letter| is_name(*letter)).collect();
        let below = |line: &&str| line.trim_start() == "}" && line.len() == indent + 1;
        let has_body = lines[first..].iter().find_map(|line| match line.trim_end().chars().last() {
            Some('{') => Some(true),
            Some(';' | '}') => Some(false),
            _ => None,
        });
        let length = match has_body {
            Some(true) => lines[first..].iter().position(below).map_or(1, |last| last + 1),
            _ => 1,
        };
        let head = lines[first..].join("\n");
        let head = &head[head.find(&name).expect("its name") + name.len()..];
        list.push(Function { name, lines: length, parameters: parameters(head) });
    }
    list
}

/// Number of parameters of a function whose text begins after its name.
fn parameters(head: &str) -> usize {
    let head = head.replace("->", "  ");
    let (mut depth, mut opened, mut list) = (0, 0, vec![String::new()]);
    for letter in head.chars() {
        depth -= i32::from(")]}>".contains(letter));
        if opened > 0 && depth < opened {
            break;
        }
        match letter {
            '(' if depth == 0 => opened = 1,
            ',' if depth == opened && opened > 0 => list.push(String::new()),
            _ if opened > 0 => list.last_mut().expect("one").push(letter),
            _ => {}
        }
        depth += i32::from("([{<".contains(letter));
    }
    list.iter().filter(|parameter| !parameter.trim().is_empty()).count()
}

/// The paths of a use tree: `a::{b, c::d}` is `a::b` and `a::c::d`.
fn paths_of(tree: &str) -> Vec<Vec<String>> {
    let tree = tree.trim();
    let parts = |text: &str| -> Vec<String> {
        text.split("::").map(|part| part.trim().to_string()).filter(|part| !part.is_empty()).collect()
    };
    let Some(open) = tree.find('{') else {
        return vec![parts(tree.split(" as ").next().unwrap_or_default())];
    };
    let head = parts(&tree[..open]);
    let inner = &tree[open + 1..tree.rfind('}').unwrap_or(tree.len())];
    let (mut depth, mut branches) = (0, vec![String::new()]);
    for letter in inner.chars() {
        depth += i32::from(letter == '{') - i32::from(letter == '}');
        match (letter, depth) {
            (',', 0) => branches.push(String::new()),
            _ => branches.last_mut().expect("one").push(letter),
        }
    }
    let branches = branches.iter().filter(|branch| !branch.trim().is_empty());
    branches.flat_map(|branch| paths_of(branch)).map(|rest| [head.clone(), rest].concat()).collect()
}

/// Use statements of a file: whether it passes them on, and their paths.
fn uses(code: &str) -> Vec<(bool, Vec<String>)> {
    let mut list = Vec::new();
    let mut from = 0;
    for line in code.lines() {
        let public = line.trim_start().starts_with("pub");
        let begin = match line.find("use ") {
            Some(at) if line[..at].trim().is_empty() || public && line[..at].trim_end().ends_with(['b', ')']) => at,
            _ => {
                from += line.len() + 1;
                continue;
            }
        };
        let tree = code[from + begin + 4..].split(';').next().unwrap_or_default();
        list.extend(paths_of(tree).into_iter().map(|path| (public, path)));
        from += line.len() + 1;
    }
    list
}

/// The file that owns what a path names, seen from a file: through what others pass on.
fn owner(modules: &BTreeMap<Module, String>, from: &Module, path: &[String], depth: usize) -> Option<Module> {
    let mut at: Module = from.clone();
    let mut rest = path;
    match rest.first().map(String::as_str) {
        Some("crate" | "fiveaxis") => (at, rest) = (Vec::new(), &rest[1..]),
        Some("self") => rest = &rest[1..],
        Some("super") => {
            while rest.first().is_some_and(|part| part == "super") {
                at.pop();
                rest = &rest[1..];
            }
        }
        Some(first) if modules.contains_key(&[at.clone(), vec![first.to_string()]].concat()) => {}
        _ => return None,
    }
    while let Some(next) = rest.first().map(|part| [at.clone(), vec![part.clone()]].concat()) {
        if !modules.contains_key(&next) {
            break;
        }
        (at, rest) = (next, &rest[1..]);
    }
    let name = rest.first().filter(|_| depth < 5);
    let passed_on = name.and_then(|name| {
        let all = uses(modules.get(&at)?);
        let (_, path) = all.into_iter().find(|(public, path)| *public && path.last() == Some(name))?;
        owner(modules, &at, &path, depth + 1)
    });
    Some(passed_on.unwrap_or(at))
}

/// Which files each file imports.
fn imports(modules: &BTreeMap<Module, String>) -> BTreeMap<Module, BTreeSet<Module>> {
    let of = |module: &Module, code: &str| -> BTreeSet<Module> {
        let mut paths: Vec<Vec<String>> = uses(code).into_iter().map(|(_, path)| path).collect();
        for start in ["crate::", "super::"] {
            for (at, _) in code.match_indices(start) {
                let end = code[at..].find(|letter: char| !(letter.is_alphanumeric() || "_:".contains(letter)));
                let text = &code[at..end.map_or(code.len(), |end| at + end)];
                let path: Vec<String> = text.split("::").filter(|part| !part.is_empty()).map(str::to_string).collect();
                // what follows in braces was read as a use statement
                paths.extend((path.len() > 1 || !text.ends_with("::")).then_some(path));
            }
        }
        // what a file calls of its own children by their bare names
        let is_child = |other: &&Module| other.len() == module.len() + 1 && other.starts_with(module);
        for child in modules.keys().filter(is_child) {
            let begin = format!("{}::", child[child.len() - 1]);
            let is_whole =
                |at: usize| !code[..at].ends_with(|letter: char| letter.is_alphanumeric() || "_:".contains(letter));
            for (at, _) in code.match_indices(&begin).filter(|(at, _)| is_whole(*at)) {
                let name = code[at + begin.len()..].split(|letter: char| !(letter.is_alphanumeric() || letter == '_'));
                paths.push([child[child.len() - 1..].to_vec(), name.take(1).map(str::to_string).collect()].concat());
            }
        }
        let owners = paths.iter().filter_map(|path| owner(modules, module, path, 0));
        owners.filter(|owner| owner != module && !owner.is_empty()).collect()
    };
    modules
        .iter()
        .filter(|(module, _)| !module.is_empty())
        .map(|(module, code)| (module.clone(), of(module, code)))
        .collect()
}

/// Files that reach themselves through their imports.
fn in_circles(imports: &BTreeMap<Module, BTreeSet<Module>>) -> BTreeSet<Module> {
    let reaches_itself = |start: &&Module| {
        let mut seen = BTreeSet::new();
        let mut next: Vec<&Module> = imports[*start].iter().collect();
        while let Some(module) = next.pop() {
            if module == *start {
                return true;
            }
            if seen.insert(module) {
                next.extend(imports.get(module).into_iter().flatten());
            }
        }
        false
    };
    imports.keys().filter(reaches_itself).cloned().collect()
}

#[test]
fn rooms_import_only_rooms_before_them() {
    let (modules, rooms) = (modules(), rooms());
    let order = |room: &str| rooms.iter().position(|other| *other == room);
    let found: BTreeSet<&str> = modules.keys().filter_map(|module| module.first()).map(String::as_str).collect();
    let unknown: Vec<&&str> = found.iter().filter(|room| order(room).is_none() && **room != "main").collect();
    assert!(unknown.is_empty(), "rooms without a place in the order: {unknown:?}");
    let mut wrong = Vec::new();
    for (module, imported) in imports(&modules).into_iter().filter(|(module, _)| module[0] != "main") {
        for other in imported.iter().filter(|other| other[0] != module[0]) {
            if order(&other[0]) > order(&module[0]) {
                wrong.push(format!("{} imports {}", module.join("::"), other.join("::")));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn no_files_import_each_other_in_circles() {
    let circles = in_circles(&imports(&modules()));
    let new: Vec<String> = circles
        .iter()
        .filter(|module| !STILL_IN_CIRCLES.contains(&module[0].as_str()))
        .map(|module| module.join("::"))
        .collect();
    assert!(new.is_empty(), "these import themselves through others: {new:#?}");
    for room in STILL_IN_CIRCLES {
        assert!(circles.iter().any(|module| module[0] == room), "{room} has no circles any more: take it off the list");
    }
}

#[test]
fn inner_rooms_import_each_other_one_way() {
    let inner = |module: &Module| (module.len() > 2).then(|| module[..2].to_vec());
    let mut between: BTreeMap<Module, BTreeSet<Module>> = BTreeMap::new();
    for (module, imported) in imports(&modules()) {
        let Some(here) = inner(&module) else { continue };
        let others =
            imported.iter().filter(|other| other.len() > 1 && other[0] == here[0]).map(|other| other[..2].to_vec());
        between.entry(here.clone()).or_default().extend(others.filter(|other| *other != here));
    }
    let circles = in_circles(&between);
    let new: Vec<String> =
        circles.iter().filter(|room| !STILL_ENTWINED.contains(&room[0].as_str())).map(|room| room.join("::")).collect();
    assert!(new.is_empty(), "these import themselves through others: {new:#?}");
    for room in STILL_ENTWINED {
        assert!(
            circles.iter().any(|inner| inner[0] == room),
            "{room} has no such circles any more: take it off the list"
        );
    }
}

#[test]
fn few_files_lie_side_by_side() {
    let mut files = Vec::new();
    files_in(&source(), &mut files);
    let mut folders: BTreeMap<String, usize> = BTreeMap::new();
    for file in files {
        let inner = file.strip_prefix(source()).expect("inside").parent().expect("a folder");
        *folders.entry(inner.to_string_lossy().replace('\\', "/")).or_default() += 1;
    }
    let is_one_per_kind = |folder: &str| ONE_FILE_PER_KIND.contains(&folder);
    let full: Vec<&String> = folders
        .iter()
        .filter(|(folder, count)| **count > MOST_SIDE_BY_SIDE && !is_one_per_kind(folder))
        .map(|(folder, _)| folder)
        .collect();
    let new: Vec<&&String> = full.iter().filter(|folder| !STILL_FLAT.contains(&folder.as_str())).collect();
    assert!(
        new.is_empty(),
        "more than {MOST_SIDE_BY_SIDE} files lie side by side in {new:?}: give them rooms by subject"
    );
    for folder in STILL_FLAT {
        assert!(full.iter().any(|other| *other == folder), "{folder} has fewer files now: take it off the list");
    }
}

#[test]
fn functions_are_read_as_they_are_written() {
    let text = "pub fn one<F: Fn(f64, f64) -> f64>(of: F, (a, b): (f64, [f64; 2])) -> f64 {\n    of(a, b[0])\n}\n\n\
                impl X {\n    fn two(\n        &self,\n        list: &[(f64, f64)],\n    ) {\n        {\n        }\n    }\n}\n\n\
                trait Y {\n    fn three();\n}\n";
    let function = |name: &str, lines, parameters| Function { name: name.into(), lines, parameters };
    assert_eq!(functions(text), [function("one", 3, 2), function("two", 7, 2), function("three", 1, 0)]);
}

#[test]
fn functions_are_short_and_take_few_parameters() {
    let mut files = Vec::new();
    files_in(&source(), &mut files);
    let mut wrong = Vec::new();
    for file in files {
        let text = std::fs::read_to_string(&file).expect("source");
        for Function { name, lines, parameters } in functions(&text) {
            if lines > MOST_LINES || parameters > MOST_PARAMETERS {
                wrong.push(format!("{}: {name} has {lines} lines and {parameters} parameters", file.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "split these into pieces that each mean something: {wrong:#?}");
}

#[test]
fn rooms_that_compute_touch_no_files_and_no_terminal() {
    let banned = ["std::fs", "std::io", "std::env", "println!(", "print!(", "eprintln!(", "dbg!("];
    for (module, code) in modules() {
        let Some(room) = module.first().filter(|room| !WITH_FILES.contains(&room.as_str()) && *room != "main") else {
            continue;
        };
        for word in banned {
            assert!(!code.contains(word), "{} uses {word} in room {room}", module.join("::"));
        }
    }
}

#[test]
fn no_effect_is_named_outside_the_catalogue() {
    // words that are also names of other things: groups of location errors, figures of circles, budgets of slides
    let other_things = [
        ("squareness", "identify"),
        ("squareness", "load"),
        ("straightness", "load"),
        ("squareness", "report"),
        ("table", "load"),
        ("table", "plan"),
        ("table", "survey"),
        ("table", "verbs"),
        ("unknown", "load"),
    ];
    for (module, code) in
        modules().into_iter().filter(|(module, _)| module.first().is_some_and(|room| room != "effects"))
    {
        for kind in KINDS {
            let is_other = other_things.contains(&(kind.name, &module[0]));
            let literal = format!("\"{}\"", kind.name);
            assert!(is_other || !code.contains(&literal), "{} names the effect {literal}", module.join("::"));
        }
    }
}

#[test]
fn numbers_that_decide_are_few_and_named_once() {
    let list = fiveaxis::diagnose::Thresholds::default().list();
    assert!(list.len() <= 40, "{} numbers decide", list.len());
    for threshold in &list {
        assert!(!threshold.meaning.is_empty() && !threshold.unit.is_empty(), "{}", threshold.name);
        assert!(threshold.value.is_finite() && threshold.off != threshold.value, "{}", threshold.name);
        let again = list.iter().filter(|other| other.name == threshold.name).count();
        assert_eq!(again, 1, "{}", threshold.name);
    }
}
