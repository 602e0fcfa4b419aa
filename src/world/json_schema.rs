//! The JSON schemas of world files and species files, written from the keys' declarations: editors complete, explain and
//! check a file with them. Only keywords that mean the same in every draft since 6 are used, since editors read different ones.

use super::schema::{Alternative, Key, Preset, Shape, Table, Unit, paragraph};
use serde_json::{Map, Value, json};
use std::ops::RangeInclusive;

type Object = Map<String, Value>;

/// The schema (JSON Schema, draft 2020-12) of a world file as JSON. Beside the standard's keywords, a number has its
/// unit in `x-unit` and the range that gives good worlds in `x-usual`.
pub fn json_schema() -> Value {
    let example = json!({ "format": 1, "seed": 2, "terrain": { "cells": 256 } });
    document("World of terrane", &super::shape(), example)
}

/// The schema of a species file, in the same way.
pub fn json_schema_of_species() -> Value {
    let example = json!({ "format": 1, "grammar": "axiom F\nF -> F[+F]F[-F]F\n", "steps": 4, "angle": 25.7 });
    document("Species of terrane", &super::species::shape(), example)
}

fn document(title: &str, shape: &Table, example: Value) -> Value {
    let mut schema = object(json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": title,
    }));
    schema.extend(table(shape));
    schema.insert("examples".into(), json!([example]));
    schema.into()
}

fn table(table: &Table) -> Object {
    let mut properties = Object::new();
    if let Some(first) = table.presets.first() {
        let words = table.presets.iter().map(|preset| (preset.name, preset_description(preset)));
        properties.insert(
            "preset".into(),
            json!({
                "title": "Preset",
                "description": "Values for several keys at once; what is written beside it wins.",
                "default": first.name,
                "type": "string",
                "oneOf": words.map(|(name, about)| word(name, &about)).collect::<Vec<_>>(),
            }),
        );
    }
    for entry in &table.keys {
        properties.insert(entry.name.into(), key(entry).into());
    }
    let required: Vec<&str> = table.keys.iter().filter(|key| key.required()).map(|key| key.name).collect();

    let mut schema = object(json!({ "description": paragraph(table.about), "type": "object" }));
    schema.insert("properties".into(), properties.into());
    schema.insert("additionalProperties".into(), false.into());
    if !required.is_empty() {
        schema.insert("required".into(), required.into());
    }
    schema
}

fn key(key: &Key) -> Object {
    let mut schema = object(json!({ "title": title(key.name), "description": description(key) }));
    if let Some(default) = key.default_value() {
        schema.insert("default".into(), from_toml(&default));
    }
    if let Some((Unit { symbol, .. }, usual)) = key.shape.number() {
        if !symbol.is_empty() {
            schema.insert("x-unit".into(), symbol.into());
        }
        if let Some(usual) = usual {
            schema.insert("x-usual".into(), usual.map(number).to_vec().into());
        }
    }
    // What the key says of itself goes before what its kind says.
    for (keyword, value) in shape(&key.shape) {
        schema.entry(keyword).or_insert(value);
    }
    schema
}

/// What may stand in a place of this shape.
fn shape(of: &Shape) -> Object {
    object(match of {
        Shape::Number { range, .. } => {
            let [least, most] = range.map(number);
            json!({ "type": "number", "minimum": least, "maximum": most })
        }
        Shape::Whole { range: [least, most] } if least == most => json!({ "const": least }),
        Shape::Whole { range: [least, most] } => {
            json!({ "type": "integer", "minimum": least, "maximum": most })
        }
        Shape::Switch => json!({ "type": "boolean" }),
        Shape::Colour => json!({
            "oneOf": [
                { "description": "sRGB.", "type": "string", "pattern": "^#[0-9a-fA-F]{6}$" },
                {
                    "description": "Red, green and blue, linear Rec.709.",
                    "type": "array",
                    "items": { "type": "number", "minimum": 0, "maximum": 1 },
                    "minItems": 3,
                    "maxItems": 3,
                },
            ],
        }),
        Shape::File => json!({ "type": "string", "minLength": 1 }),
        Shape::Choice(words) => {
            let words: Vec<_> = words.iter().map(|[name, about]| word(name, about)).collect();
            json!({ "type": "string", "oneOf": words })
        }
        // The elements of an array differ in their defaults only.
        Shape::Array(elements) => array(elements.first(), elements.len()..=elements.len()),
        Shape::List { element, len: [least, most], .. } => array(Some(element), *least..=*most),
        Shape::Table(inner) => table(inner).into(),
        Shape::OneOf(alternatives) => one_of(alternatives).into(),
        Shape::Text(_) => json!({ "type": "string" }),
        Shape::OrWord(inner, [name, about]) => or_words(shape(inner), vec![word(name, about)]).into(),
        Shape::Named { names, element, .. } => json!({
            "type": "object",
            "propertyNames": { "pattern": names.pattern() },
            "additionalProperties": shape(element),
        }),
    })
}

fn array(element: Option<&Shape>, len: RangeInclusive<usize>) -> Value {
    json!({
        "type": "array",
        "items": element.map(shape),
        "minItems": len.start(),
        "maxItems": len.end(),
    })
}

/// A table with exactly one of the alternatives, or a word. One table holds them all, so that a mistake inside one of
/// them is shown where it is, and not as "matches none of these".
fn one_of(alternatives: &[Alternative]) -> Object {
    let (mut properties, mut words) = (Object::new(), Vec::new());
    for Alternative { name, about, table: inner, .. } in alternatives {
        match inner {
            Some(inner) => {
                properties.insert((*name).into(), table(inner).into());
            }
            None => words.push(word(name, about)),
        }
    }
    let schema = object(json!({
        "type": "object",
        "properties": properties,
        "additionalProperties": false,
        "minProperties": 1,
        "maxProperties": 1,
    }));
    if words.is_empty() { schema } else { or_words(schema, words) }
}

/// What `schema` allows, or one of the words. Its other keywords say nothing of values that are not of its type, so
/// that only the type moves into the choice.
fn or_words(mut schema: Object, words: Vec<Value>) -> Object {
    let first = match schema.remove("type") {
        Some(kind) => json!({ "type": kind }),
        None => std::mem::take(&mut schema).into(),
    };
    schema.insert("anyOf".into(), [vec![first], words].concat().into());
    schema
}

fn word(name: &str, about: &str) -> Value {
    json!({ "description": paragraph(about), "const": name })
}

/// A key's meaning, and in words what editors don't show from the other keywords.
fn description(key: &Key) -> String {
    let mut description = paragraph(key.about);
    if let Some((unit, usual)) = key.shape.number() {
        if !unit.symbol.is_empty() {
            description += &format!(" Unit: {}.", unit.symbol);
        }
        if let Some([least, most]) = usual {
            description += &format!(" Usual: {least} to {most}.");
        }
    }
    if !key.required() && key.default_value().is_none() {
        description += &format!(" Default: {}.", key.default);
    }
    description
}

fn preset_description(preset: &Preset) -> String {
    let keys = preset.keys.trim().replace('\n', ", ");
    if keys.is_empty() { preset.about.into() } else { format!("{}: {keys}", preset.about) }
}

/// A key's name as a heading.
fn title(name: &str) -> String {
    let mut letters = name.chars();
    let first = letters.next().map(char::to_uppercase);
    first.into_iter().flatten().chain(letters).collect::<String>().replace('_', " ")
}

fn from_toml(value: &toml_edit::Value) -> Value {
    use toml_edit::Value as Toml;
    match value {
        Toml::String(word) => word.value().as_str().into(),
        Toml::Integer(whole) => (*whole.value()).into(),
        Toml::Float(float) => number(*float.value()),
        Toml::Boolean(switch) => (*switch.value()).into(),
        Toml::Datetime(date) => date.value().to_string().into(),
        Toml::Array(elements) => elements.iter().map(from_toml).collect(),
        Toml::InlineTable(table) => {
            table.iter().map(|(name, value)| (name.to_string(), from_toml(value))).collect::<Object>().into()
        }
    }
}

/// A number as JSON, without a point where it is whole.
fn number(value: f64) -> Value {
    const EXACT: f64 = 9_007_199_254_740_992.0; // 2^53
    if value.fract() == 0.0 && value.abs() < EXACT { (value as i64).into() } else { value.into() }
}

fn object(value: Value) -> Object {
    match value {
        Value::Object(object) => object,
        _ => Object::new(),
    }
}
