//! No file of a crate is part of a dependency cycle of files. Test modules and re-exports (`pub use`)
//! do not count as dependencies.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

use evac_tests::repository;
use syn::{Item, UsePath, UseTree, visit_mut::VisitMut};

/// The root files of all crates.
fn roots() -> Vec<PathBuf> {
    let crates = fs::read_dir(repository().join("crates")).expect("the crates");
    let crates = crates.map(|entry| entry.expect("a directory").path());
    let others = ["agent_node", "msgs", "sim_node", "tests"].map(|name| repository().join(name));
    let mut roots = Vec::new();
    for directory in crates.chain(others) {
        let source = directory.join("src");
        roots.extend(["lib.rs", "main.rs"].map(|name| source.join(name)));
        for program in fs::read_dir(source.join("bin")).into_iter().flatten() {
            roots.push(program.expect("a directory entry").path().join("main.rs"));
        }
    }
    roots.retain(|root| root.exists());
    roots
}

/// The files of a crate and how they refer to each other.
#[derive(Default)]
struct Files {
    /// The file of each module, by its path from the root of the crate.
    modules: BTreeMap<Vec<String>, PathBuf>,
    /// The target of each re-export (`pub use`), by module and name.
    exports: BTreeMap<(Vec<String>, String), Vec<String>>,
    /// Each use of a path: the module, and the path as written in its source.
    uses: Vec<(Vec<String>, Vec<String>)>,
}

impl Files {
    fn read(root: &Path) -> Files {
        let mut files = Files::default();
        files.add(Vec::new(), root, root.parent().expect("a directory"));
        files
    }

    fn add(&mut self, module: Vec<String>, path: &Path, children: &Path) {
        let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let mut file = syn::parse_file(&text).expect("Rust");
        self.modules.insert(module.clone(), path.to_owned());
        let mut visitor = Uses { files: self, module: module.clone(), nested: Vec::new() };
        visitor.visit_file_mut(&mut file);
        for name in visitor.nested {
            let own = children.join(format!("{name}.rs"));
            let path = if own.exists() { own } else { children.join(&name).join("mod.rs") };
            self.add(
                [&module[..], std::slice::from_ref(&name)].concat(),
                &path,
                &children.join(&name),
            );
        }
    }

    /// Returns the file that defines what `path` names in `module`; `None` if it is in another crate.
    fn resolve(&self, module: &[String], path: &[String], depth: u32) -> Option<&Path> {
        let (mut at, rest): (Vec<String>, &[String]) = match path.first()?.as_str() {
            "crate" => (Vec::new(), &path[1..]),
            "self" => (module.to_vec(), &path[1..]),
            "super" => (module.split_last()?.1.to_vec(), &path[1..]),
            name => {
                let child = [module, &[name.to_owned()]].concat();
                let is_known = self.modules.contains_key(&child)
                    || self.exports.contains_key(&(module.to_vec(), name.to_owned()));
                (is_known.then(|| module.to_vec())?, path)
            }
        };
        for (index, name) in rest.iter().enumerate() {
            if name == "super" {
                at.pop();
                continue;
            }
            let child = [&at[..], std::slice::from_ref(name)].concat();
            if self.modules.contains_key(&child) {
                at = child;
            } else if let Some(target) = self.exports.get(&(at.clone(), name.clone())) {
                let target = [&target[..], &rest[index + 1..]].concat();
                return (depth < 9).then(|| self.resolve(&at, &target, depth + 1))?;
            } else {
                break;
            }
        }
        self.modules.get(&at).map(PathBuf::as_path)
    }

    /// Returns the files that each file uses.
    fn edges(&self) -> BTreeMap<&Path, BTreeSet<&Path>> {
        let mut edges = BTreeMap::<&Path, BTreeSet<&Path>>::new();
        for (module, path) in &self.uses {
            let from = self.modules[module].as_path();
            if let Some(to) = self.resolve(module, path, 0).filter(|to| *to != from) {
                edges.entry(from).or_default().insert(to);
            }
        }
        edges
    }
}

/// Collects what a module uses, without its tests.
struct Uses<'a> {
    files: &'a mut Files,
    module: Vec<String>,
    /// The modules that it declares, in files of their own.
    nested: Vec<String>,
}

impl Uses<'_> {
    fn import(&mut self, prefix: &[String], tree: &UseTree, is_export: bool) {
        let (path, name) = match tree {
            UseTree::Path(UsePath { ident, tree, .. }) => {
                return self.import(&[prefix, &[ident.to_string()]].concat(), tree, is_export);
            }
            UseTree::Group(group) => {
                return group.items.iter().for_each(|tree| self.import(prefix, tree, is_export));
            }
            UseTree::Glob(_) => {
                return self.files.uses.push((self.module.clone(), prefix.to_vec()));
            }
            UseTree::Name(name) if name.ident == "self" => {
                (prefix.to_vec(), prefix.last().expect("a module").clone())
            }
            UseTree::Name(name) => {
                ([prefix, &[name.ident.to_string()]].concat(), name.ident.to_string())
            }
            UseTree::Rename(rename) => {
                ([prefix, &[rename.ident.to_string()]].concat(), rename.rename.to_string())
            }
        };
        match is_export {
            // An interface that is passed on is not used.
            true => drop(self.files.exports.insert((self.module.clone(), name), path)),
            false => self.files.uses.push((self.module.clone(), path)),
        }
    }
}

impl VisitMut for Uses<'_> {
    fn visit_item_mut(&mut self, item: &mut Item) {
        let attributes: &[_] = match item {
            Item::Mod(item) => &item.attrs,
            Item::Fn(item) => &item.attrs,
            Item::Use(item) => &item.attrs,
            Item::Impl(item) => &item.attrs,
            _ => &[],
        };
        let is_test = |attribute: &syn::Attribute| {
            let tokens = attribute.meta.require_list().map(|list| list.tokens.to_string());
            attribute.path().is_ident("cfg") && tokens.is_ok_and(|tokens| tokens == "test")
        };
        if attributes.iter().any(is_test) {
            return;
        }
        match item {
            Item::Mod(item) if item.content.is_none() => self.nested.push(item.ident.to_string()),
            Item::Use(item) => {
                let is_export = !matches!(item.vis, syn::Visibility::Inherited);
                self.import(&[], &item.tree, is_export);
            }
            _ => syn::visit_mut::visit_item_mut(self, item),
        }
    }

    /// Collects the paths in the arguments of a macro, such as `crate::module::name`.
    fn visit_macro_mut(&mut self, call: &mut syn::Macro) {
        let text = call.tokens.to_string().replace(" :: ", "::");
        for word in text.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')) {
            let names: Vec<String> = word.split("::").map(str::to_owned).collect();
            if names.len() > 1 && names.iter().all(|name| !name.is_empty()) {
                self.files.uses.push((self.module.clone(), names));
            }
        }
        syn::visit_mut::visit_macro_mut(self, call);
    }

    fn visit_path_mut(&mut self, path: &mut syn::Path) {
        let names: Vec<String> =
            path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        // A single name was imported, or is defined here.
        if names.len() > 1 {
            self.files.uses.push((self.module.clone(), names));
        }
        syn::visit_mut::visit_path_mut(self, path);
    }
}

/// Returns a circle of files through `file`, if there is one.
fn circle<'a>(
    edges: &BTreeMap<&'a Path, BTreeSet<&'a Path>>,
    file: &'a Path,
) -> Option<Vec<&'a Path>> {
    let mut ways: Vec<Vec<&Path>> = vec![vec![file]];
    let mut seen = BTreeSet::new();
    while let Some(way) = ways.pop() {
        let last = way.last().expect("a way has a file");
        for next in edges.get(last).into_iter().flatten() {
            if *next == file {
                return Some(way);
            }
            if seen.insert(*next) {
                ways.push([&way[..], &[*next]].concat());
            }
        }
    }
    None
}

#[test]
fn no_file_of_a_crate_takes_part_in_a_circle() {
    let mut circles = BTreeSet::new();
    let mut count = 0;
    for root in roots() {
        let files = Files::read(&root);
        let edges = files.edges();
        count += edges.values().map(BTreeSet::len).sum::<usize>();
        for file in edges.keys() {
            if let Some(circle) = circle(&edges, file) {
                let mut names: Vec<_> =
                    circle.iter().map(|p| p.strip_prefix(repository()).unwrap_or(p)).collect();
                names.sort();
                circles.insert(names.iter().map(|p| p.display().to_string()).collect::<Vec<_>>());
            }
        }
    }
    assert!(count > 300, "only {count} uses were found");
    assert!(circles.is_empty(), "{circles:#?}");
}
