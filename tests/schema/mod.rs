//! A check of JSON against the part of JSON Schema that the schemas of this repository use. It is no validator for others.

use serde_json::Value;

/// Violations, by place.
pub fn violations_of(schema: &Value, value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    violations(schema, value, "$", &mut found);
    found
}

/// Violations of a schema: types, required and unknown keys, enumerations and lengths of lists, which is all it uses.
fn violations(schema: &Value, value: &Value, place: &str, found: &mut Vec<String>) {
    let is = |name: &str| match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_u64() || value.is_i64(),
        "number" => value.is_number(),
        "null" => value.is_null(),
        other => panic!("the schema at {place} names the type {other}, which this check does not know"),
    };
    match &schema["type"] {
        Value::String(name) if !is(name) => found.push(format!("{place} is no {name}: {value}")),
        Value::Array(names) if !names.iter().filter_map(Value::as_str).any(is) => {
            found.push(format!("{place} is none of {names:?}: {value}"));
        }
        _ => {}
    }
    if let Some(allowed) = schema["enum"].as_array()
        && !allowed.contains(value)
    {
        found.push(format!("{place} is {value}, not one of {allowed:?}"));
    }
    if let Some(object) = value.as_object() {
        for key in schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str) {
            if !object.contains_key(key) {
                found.push(format!("{place} has no {key}"));
            }
        }
        for (key, inner) in object {
            let place = format!("{place}.{key}");
            match (&schema["properties"][key], &schema["additionalProperties"]) {
                (Value::Null, Value::Bool(false)) => found.push(format!("{place} is not in the schema")),
                (Value::Null, Value::Object(_)) => violations(&schema["additionalProperties"], inner, &place, found),
                (Value::Null, _) => {}
                (property, _) => violations(property, inner, &place, found),
            }
        }
    }
    if let Some(list) = value.as_array() {
        let bound = |key: &str| schema[key].as_u64().map(|bound| bound as usize);
        if bound("minItems").is_some_and(|least| list.len() < least)
            || bound("maxItems").is_some_and(|most| list.len() > most)
        {
            found.push(format!("{place} has {} entries", list.len()));
        }
        for (index, inner) in list.iter().enumerate() {
            violations(&schema["items"], inner, &format!("{place}[{index}]"), found);
        }
    }
}
