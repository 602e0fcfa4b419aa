//! The JSON schema of world files, written from the keys' declarations: editors complete, explain and check a world
//! with it. Only keywords that mean the same in every draft since 6 are used, since editors read different ones.

use super::schema::{Alternative, Key, Preset, Shape, Table, Unit, paragraph};
use serde_json::{Map, Value, json};
use std::ops::RangeInclusive;

type Object = Map<String, Value>;

/// The schema (JSON Schema, draft 2020-12) of a world file as JSON. Beside the standard's keywords, a number has its
/// unit in `x-unit` and the range that gives good worlds in `x-usual`.
pub fn json_schema() -> Value {
    let mut schema = object(json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "World of terrane",
    }));
    schema.extend(table(&super::shape()));
    schema.insert("examples".into(), json!([{ "format": 1, "seed": 2, "terrain": { "cells": 256 } }]));
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
            json!({ "oneOf": words.iter().map(|[name, about]| word(name, about)).collect::<Vec<_>>() })
        }
        // The elements of an array differ in their defaults only.
        Shape::Array(elements) => array(elements.first(), elements.len()..=elements.len()),
        Shape::List { element, len: [least, most] } => array(Some(element), *least..=*most),
        Shape::Table(inner) => table(inner).into(),
        Shape::OneOf(alternatives) => {
            let available = alternatives.iter().filter(|alternative| alternative.available);
            json!({ "oneOf": available.map(alternative).collect::<Vec<_>>() })
        }
        // Not `oneOf`: "none" is also the name of a file.
        Shape::OrNone(inner) => json!({ "anyOf": [shape(inner), word("none", "Nothing.")] }),
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

fn alternative(alternative: &Alternative) -> Value {
    let Alternative { name, about, table: inner, .. } = alternative;
    let Some(inner) = inner else { return word(name, about) };
    json!({
        "description": paragraph(about),
        "type": "object",
        "properties": { *name: table(inner) },
        "additionalProperties": false,
        "required": [name],
    })
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
