//! The section in a file: the keys of the host and those of the core's table.

use std::borrow::Cow;
use std::fmt;

use bonebeam::beamform::{Parameter, Parameters};
use serde::de::value::{CowStrDeserializer, MapAccessDeserializer};
use serde::de::{DeserializeSeed, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::super::core::{APODIZATION, POSTFILTER, plain, row};
use super::Beamform;

impl Serialize for Beamform {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Section<'a> {
            #[serde(flatten)]
            host: Host<'a>,
            #[serde(flatten)]
            core: Core<'a>,
        }
        let section = Section {
            host: Host(self),
            core: Core(&self.core),
        };
        section.serialize(serializer)
    }
}

struct Host<'a>(&'a Beamform);

impl Serialize for Host<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        Beamform::serialize(self.0, serializer)
    }
}

struct Core<'a>(&'a Parameters);

impl Serialize for Core<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry(POSTFILTER, self.0.postfilter.key())?;
        map.serialize_entry(APODIZATION, self.0.apodization.key())?;
        for (row, value) in Parameters::TABLE.into_iter().zip(self.0.values()) {
            match row.whole {
                true => map.serialize_entry(row.name, &(value as u64))?,
                false => map.serialize_entry(row.name, &plain(value))?,
            }
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Beamform {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        deserializer.deserialize_map(Section)
    }
}

struct Section;

impl<'de> Visitor<'de> for Section {
    type Value = Beamform;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a section of keys")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> std::result::Result<Beamform, A::Error> {
        let mut core = Parameters::DEFAULT;
        let mut rows = Vec::new();
        let others = Others {
            map,
            core: &mut core,
            rows: &mut rows,
        };
        let section = Beamform::deserialize(MapAccessDeserializer::new(others))?;
        let preset = section.preset;
        let preset = preset.and_then(|preset| preset.unless(|key| rows.contains(&key)));
        Ok(Beamform {
            core,
            preset,
            ..section
        })
    }
}

/// The entries of a map without the core's, which are stored in `core`.
struct Others<'a, A> {
    map: A,
    core: &'a mut Parameters,
    /// Rows of the core's table in the map, which override those of a preset.
    rows: &'a mut Vec<&'static str>,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Others<'_, A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> std::result::Result<Option<K::Value>, A::Error> {
        let mut seed = Some(seed);
        while let Some(key) = self.map.next_key_seed(KeySeed(&mut seed))? {
            match key {
                Key::Other(key) => return Ok(Some(key)),
                Key::Postfilter => self.core.postfilter = self.map.next_value()?,
                Key::Apodization => self.core.apodization = self.map.next_value()?,
                Key::Row(row) => {
                    self.rows.push(row.name);
                    let value = match row.whole {
                        true => self.map.next_value::<usize>()? as f64,
                        false => self.map.next_value()?,
                    };
                    self.core.set(row.name, value).expect("a row of the table");
                }
            }
        }
        Ok(None)
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> std::result::Result<T::Value, A::Error> {
        self.map.next_value_seed(seed)
    }
}

enum Key<T> {
    Row(&'static Parameter),
    Postfilter,
    Apodization,
    Other(T),
}

/// Reads a key; the inner seed reads keys that are not the core's.
struct KeySeed<'a, K>(&'a mut Option<K>);

impl<'de, K: DeserializeSeed<'de>> DeserializeSeed<'de> for KeySeed<'_, K> {
    type Value = Key<K::Value>;

    fn deserialize<D: Deserializer<'de>>(
        self,
        deserializer: D,
    ) -> std::result::Result<Self::Value, D::Error> {
        let key = Cow::<str>::deserialize(deserializer)?;
        if let Some(row) = row(&key) {
            return Ok(Key::Row(row));
        }
        if key == POSTFILTER {
            return Ok(Key::Postfilter);
        }
        if key == APODIZATION {
            return Ok(Key::Apodization);
        }
        let seed = self.0.take().expect("one key of another kind at a time");
        let key = seed.deserialize(CowStrDeserializer::new(key))?;
        Ok(Key::Other(key))
    }
}
