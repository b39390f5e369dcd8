//! No crate has a cycle of files, or of folders, that use each other.

use crate::common::kit::*;
use std::collections::{BTreeMap, BTreeSet};

/// The parts of a path, of a module or of an item.
type Names = Vec<String>;

/// Contents of a file, without comments and unit tests.
#[derive(Default)]
struct File {
    /// The paths of its `use` lines, and whether they are public.
    imports: Vec<(bool, Names)>,
    /// The paths within its code.
    paths: Vec<Names>,
}

fn names(path: &str) -> Names {
    let parts = path.split("::").map(str::trim);
    parts.filter(|p| !p.is_empty()).map(String::from).collect()
}

/// The paths of a `use` line: `a::{b, c::d}` is `a::b` and `a::c::d`.
fn expand(tree: &str) -> Vec<Names> {
    let Some((prefix, inner)) = tree.split_once('{') else {
        let mut path = names(tree.split(" as ").next().unwrap());
        path.pop_if(|last| last == "self");
        return vec![path];
    };
    let inner = inner.rsplit_once('}').unwrap().0;
    let mut depth = 0;
    let parts = inner.split(|c| {
        depth += i32::from(c == '{') - i32::from(c == '}');
        c == ',' && depth == 0
    });
    let paths = parts
        .filter(|part| !part.trim().is_empty())
        .flat_map(expand);
    paths.map(|path| [names(prefix), path].concat()).collect()
}

impl File {
    fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path).unwrap();
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
        let code: String = (code.lines())
            .map(|line| format!("{}\n", line.split("//").next().unwrap()))
            .collect();
        let mut file = File::default();
        for statement in code.split(';') {
            let (before, tree) = statement.rsplit_once("use ").unwrap_or(("code", ""));
            let public = before.ends_with("pub ") || before.ends_with(") ");
            if public || before.is_empty() || before.ends_with('\n') {
                let paths = expand(tree).into_iter();
                file.imports.extend(paths.map(|path| (public, path)));
            } else {
                let words = statement.split(|c: char| !(c.is_alphanumeric() || "_:".contains(c)));
                let paths = words.filter(|word| word.contains("::")).map(names);
                file.paths.extend(paths);
            }
        }
        file
    }
}

/// The files of a crate by the paths of their modules.
struct Crate(BTreeMap<Names, File>);

impl Crate {
    fn add(&mut self, folder: &Path, module: &Names) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_str().unwrap();
            let child = [&module[..], &[name.to_owned()]].concat();
            if path.is_dir() {
                self.add(&path, &child);
            } else if path.extension().is_some_and(|e| e == "rs") && name != "main" {
                let own = name == "lib" || name == "mod";
                let module = if own { module.clone() } else { child };
                self.0.insert(module, File::read(&path));
            }
        }
    }

    /// A path from the root of the crate; `None` for a path of another crate.
    fn absolute(&self, module: &Names, path: &[String]) -> Option<Names> {
        let supers = path.iter().take_while(|part| *part == "super").count();
        let (start, rest) = match path.first()?.as_str() {
            "crate" => (0, 1),
            "self" => (module.len(), 1),
            "super" => (module.len().checked_sub(supers)?, supers),
            child => {
                let child = [&module[..], &[child.to_owned()]].concat();
                self.0.get(&child)?;
                (module.len(), 0)
            }
        };
        Some([&module[..start], &path[rest..]].concat())
    }

    /// The module that defines the item of a path. A module that only imports the item does not.
    fn home(&self, path: &Names) -> Option<Names> {
        let length = (0..=path.len())
            .rev()
            .find(|&n| self.0.contains_key(&path[..n]))?;
        let (module, rest) = (path[..length].to_vec(), &path[length..]);
        let imports = &self.0[&module].imports;
        let import = rest.first().and_then(|item| {
            let mut found = imports
                .iter()
                .filter(|(_, import)| import.last() == Some(item));
            found.next().map(|(_, import)| import)
        });
        match import.map(|import| self.absolute(&module, import)) {
            None => Some(module),
            Some(import) => import
                .filter(|import| import != path)
                .and_then(|p| self.home(&p)),
        }
    }

    /// The modules that a module uses; a public `use` re-exports and does not count.
    fn uses(&self, module: &Names) -> BTreeSet<Names> {
        let file = &self.0[module];
        let imports = file.imports.iter().filter(|(public, _)| !public);
        let paths = imports.map(|(_, path)| path).chain(&file.paths);
        let homes = paths.filter_map(|path| self.home(&self.absolute(module, path)?));
        homes.filter(|home| home != module).collect()
    }

    /// The cycles: sets of modules, or of folders in `src`, in which each leads to all others.
    fn circles(&self, folders: bool) -> BTreeSet<BTreeSet<Names>> {
        let place = |module: &Names| match folders {
            true => module[..module.len().min(1)].to_vec(),
            false => module.clone(),
        };
        let mut uses: BTreeMap<Names, BTreeSet<Names>> = BTreeMap::new();
        for module in self.0.keys() {
            let own = place(module);
            let used = self.uses(module).iter().map(place).collect::<Vec<_>>();
            let used = used.into_iter().filter(|used| *used != own);
            uses.entry(own.clone()).or_default().extend(used);
        }
        let reach = |module: &Names| {
            let (mut found, mut next) = (BTreeSet::new(), vec![module.clone()]);
            while let Some(module) = next.pop() {
                let new = uses[&module]
                    .iter()
                    .filter(|used| found.insert((*used).clone()));
                next.extend(new.cloned());
            }
            found
        };
        let all: BTreeMap<_, _> = uses.keys().map(|m| (m, reach(m))).collect();
        let circle = |(module, reach): (&&Names, &BTreeSet<Names>)| {
            let back = reach.iter().filter(|other| all[other].contains(*module));
            back.cloned().collect::<BTreeSet<Names>>()
        };
        all.iter()
            .map(circle)
            .filter(|circle| !circle.is_empty())
            .collect()
    }
}

/// The folders of the crates in and below a folder.
///
/// These are the `members` of its workspace, and the workspaces in `exclude`.
fn crates(folder: &Path) -> Vec<PathBuf> {
    let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
    let workspace = manifest.split_once("[workspace]\n");
    let workspace = workspace.and_then(|(_, rest)| rest.split("\n[").next());
    let lists = ["members = [", "exclude = ["].map(|key| {
        let list = workspace.and_then(|workspace| workspace.split_once(key));
        list.map_or("", |(_, rest)| rest.split(']').next().unwrap())
    });
    let quoted = lists
        .iter()
        .flat_map(|list| list.split('"').skip(1).step_by(2));
    let below = quoted.flat_map(|name| crates(&folder.join(name)));
    let own = folder.join("src").is_dir().then(|| folder.to_owned());
    own.into_iter().chain(below).collect()
}

#[test]
fn no_files_use_each_other() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let crates = crates(root);
    for known in ["core", "host-sim/formats", "firmware/stream", "paper"] {
        assert!(crates.contains(&root.join(known)), "{known}");
    }
    let mut found = Vec::new();
    for folder in crates {
        let mut files = Crate(BTreeMap::new());
        files.add(&folder.join("src"), &Vec::new());
        assert!(!files.0.is_empty(), "{}", folder.display());
        let mut circles = files.circles(false);
        // In the driver, sections of the configuration and their users know each other.
        if !folder.ends_with("drive") {
            circles.extend(files.circles(true));
        }
        let circles = circles.iter();
        found.extend(circles.map(|circle| format!("{}: {circle:?}", folder.display())));
    }
    assert!(found.is_empty(), "{found:#?}");
}
