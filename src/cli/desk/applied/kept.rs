//! Changes of a TOML text that leave the rest of it, comments included, as it is.

use toml_edit::{Decor, InlineTable, Item, RawString, Table, TableLike, Value};

/// Puts a value; the comments around the old one stay. One that says the same already stays to the byte.
pub fn put(table: &mut dyn TableLike, key: &str, new: Item) {
    match table.get_mut(key) {
        Some(old) => renew(old, new),
        None => {
            table.insert(key, new);
        }
    }
}

/// Makes a table say what another one says.
pub fn put_all(table: &mut Table, new: Table) {
    let keys: Vec<String> = table.iter().map(|(key, _)| key.to_owned()).collect();
    for gone in keys.iter().filter(|key| !new.contains_key(key)) {
        let comments = take_out(table, gone);
        comment_above(table.decor_mut(), &comments);
    }
    for (key, item) in new {
        put(table, &key, item);
    }
}

/// Takes a key out, and returns the comments above it and beside it.
pub fn take_out(table: &mut dyn TableLike, key: &str) -> Vec<String> {
    let above = table.key(key).map(|key| lines(key.leaf_decor().prefix()));
    let beside = table.remove(key).and_then(|item| Some(lines(item.as_value()?.decor().suffix())));
    above.into_iter().chain(beside).flatten().collect()
}

/// Puts comments above what is there.
pub fn comment_above(decor: &mut Decor, comments: &[String]) {
    if !comments.is_empty() {
        let old = decor.prefix().and_then(RawString::as_str).unwrap_or_default().to_owned();
        decor.set_prefix(format!("\n{}\n{}", comments.join("\n"), old.trim_start_matches(['\n', '\r'])));
    }
}

fn renew(old: &mut Item, new: Item) {
    if let (Some(there), Some(wanted)) = (old.as_table_like_mut(), new.as_table_like())
        && there.iter().map(|(key, _)| key).eq(wanted.iter().map(|(key, _)| key))
    {
        for (key, item) in wanted.iter() {
            put(there, key, item.clone());
        }
        return;
    }
    match (old, new) {
        (Item::Value(old), Item::Value(mut new)) => {
            if !is_same(old, &new) {
                *new.decor_mut() = old.decor().clone();
                *old = new;
            }
        }
        // A table under a heading of its own stays one.
        (Item::Table(old), Item::Value(Value::InlineTable(new))) => merge(old, new),
        (old, new) => *old = new,
    }
}

fn merge(old: &mut Table, new: InlineTable) {
    for (key, value) in new {
        put(old, &key, Item::Value(value));
    }
}

/// Do two values say the same, however they are written?
fn is_same(a: &Value, b: &Value) -> bool {
    let number = |value: &Value| value.as_float().or(value.as_integer().map(|whole| whole as f64));
    match (number(a), number(b)) {
        (Some(a), Some(b)) => a == b,
        _ => a.as_str().is_some() && a.as_str() == b.as_str(),
    }
}

/// The lines of a stretch between values that say something.
fn lines(between: Option<&RawString>) -> Vec<String> {
    let text = between.and_then(RawString::as_str).unwrap_or_default();
    text.lines().map(str::trim).filter(|line| !line.is_empty()).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use toml_edit::{DocumentMut, value};

    fn changed(text: &str, change: impl FnOnce(&mut Table)) -> String {
        let mut document: DocumentMut = text.parse().unwrap();
        change(document["car"].as_table_mut().unwrap());
        document.to_string()
    }

    fn uncertain(number: f64, std: f64) -> Item {
        let mut table = InlineTable::new();
        table.insert("value", number.into());
        table.insert("std", std.into());
        value(table)
    }

    #[test]
    fn what_changes_keeps_its_comments_and_the_rest_its_bytes() {
        let text = "# The car.\n[car]\n# From the scale.\nmass = 1700   # with me\nlength =  2.50 #!\n\
                    ratio = { value = 15.5, std = 0.5 }\t# guessed\n\n# End.\n";
        let new = changed(text, |car| {
            put(car, "mass", uncertain(1650.0, 20.0));
            put(car, "ratio", uncertain(16.0, 0.25));
            put(car, "length", value(2.5));
            put(car, "drag", value(0.4));
        });
        let wanted = text
            .replace("1700 ", "{ value = 1650.0, std = 20.0 } ")
            .replace("15.5, std = 0.5", "16.0, std = 0.25")
            .replace("# guessed\n", "# guessed\ndrag = 0.4\n");
        assert_eq!(new, wanted);
    }

    #[test]
    fn numbers_in_tables_of_their_own_are_put_there() {
        let text = "[car]\nratio.value = 15.5 # guessed\n[car.mass] # scale\nvalue = 1700\n";
        let new = changed(text, |car| {
            put(car, "mass", uncertain(1650.0, 20.0));
            put(car, "ratio", uncertain(16.0, 0.25));
        });
        for line in ["[car.mass] # scale", "value = 1650.0", "std = 20.0", "ratio.value = 16.0 # guessed"] {
            assert!(new.contains(line), "{line} is not in\n{new}");
        }
        let read: toml::Table = new.parse().unwrap();
        assert_eq!(read["car"]["ratio"]["std"].as_float(), Some(0.25), "{new}");
    }

    #[test]
    fn a_table_becomes_another_one() {
        let text = "# Mine.\n[car]\n# Which.\nkind = \"a\" # this\n# Since March.\nfrom = 3 # days\nmass = 1.0 # t\n";
        let new = changed(text, |car| {
            let other: DocumentMut = "kind = \"a\"\nmass = 2.0\n".parse().unwrap();
            put_all(car, other.as_table().clone());
        });
        let head = "\n# Since March.\n# days\n# Mine.\n[car]\n";
        assert_eq!(new, format!("{head}# Which.\nkind = \"a\" # this\nmass = 2.0 # t\n"));
    }
}
