//! The XML of the parts of a package.

use crate::error::Fault;
use crate::source::Source;
use crate::text::coordinate;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::HashMap;
use std::str::FromStr;

/// The XML of a part.
pub(super) struct Xml<'x> {
    path: &'x str,
    bytes: &'x [u8],
    reader: Reader<&'x [u8]>,
}

impl<'x> Xml<'x> {
    pub(super) fn new(path: &'x str, bytes: &'x [u8]) -> Self {
        Self { path, bytes, reader: Reader::from_reader(bytes) }
    }

    pub(super) fn next(&mut self) -> Result<Option<Event<'x>>, Fault> {
        match self.reader.read_event() {
            Ok(Event::Eof) => Ok(None),
            Ok(event) => Ok(Some(event)),
            Err(error) => Err(self.fault(error.to_string())),
        }
    }

    /// The line of the file that is being read.
    fn line(&self) -> usize {
        let read = self.bytes.get(..self.reader.buffer_position() as usize);
        1 + read.unwrap_or_default().iter().filter(|&&byte| byte == b'\n').count()
    }

    pub(super) fn fault(&self, what: impl std::fmt::Display) -> Fault {
        Fault::line(self.line(), format!("{what} (in {})", self.path))
    }

    /// An attribute, with its entities resolved.
    pub(super) fn text(
        &self,
        element: &BytesStart<'_>,
        name: &str,
    ) -> Result<Option<String>, Fault> {
        for attribute in element.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| self.fault(error))?;
            if attribute.key.as_ref() == name {
                let text = quick_xml::escape::unescape(&attribute.value);
                let text = text.map_err(|error| self.fault(error))?;
                return Ok(Some(text.into_owned()));
            }
        }
        Ok(None)
    }

    /// An attribute that has to be there.
    pub(super) fn number<T: FromStr>(
        &self,
        element: &BytesStart<'_>,
        name: &str,
    ) -> Result<T, Fault> {
        for attribute in element.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| self.fault(error))?;
            if attribute.key.as_ref() == name {
                let number = attribute.value.trim().parse().ok();
                return number.ok_or_else(|| self.fault(format!("{name} is no number")));
            }
        }
        Err(self.fault(format!("{name} is missing")))
    }

    pub(super) fn position(
        &self,
        element: &BytesStart<'_>,
        source: &mut Source,
    ) -> Result<[f64; 3], Fault> {
        let mut position = [None; 3];
        for attribute in element.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| self.fault(error))?;
            let axis = ["x", "y", "z"].iter().position(|axis| attribute.key.as_ref() == *axis);
            if let Some(axis) = axis {
                let number = coordinate(attribute.value.trim().as_bytes(), source);
                position[axis] =
                    Some(number.ok_or_else(|| self.fault("a coordinate is no number"))?);
            }
        }
        let [Some(x), Some(y), Some(z)] = position else {
            return Err(self.fault("a vertex without x, y or z"));
        };
        Ok([x, y, z])
    }

    /// The namespaces that an element declares, by their prefixes.
    pub(super) fn namespaces(
        &self,
        element: &BytesStart<'_>,
    ) -> Result<HashMap<String, String>, Fault> {
        let mut all = HashMap::new();
        for attribute in element.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| self.fault(error))?;
            if let Some(prefix) = attribute.key.as_ref().strip_prefix("xmlns:") {
                let text = quick_xml::escape::unescape(&attribute.value);
                let text = text.map_err(|error| self.fault(error))?;
                all.insert(prefix.to_owned(), text.into_owned());
            }
        }
        Ok(all)
    }

    /// The attribute `path` of the production extension, whatever prefix that has.
    pub(super) fn path(&self, element: &BytesStart<'_>) -> Result<Option<String>, Fault> {
        let mut path = None;
        for attribute in element.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| self.fault(error))?;
            if attribute.key.local_name().as_ref() == "path" {
                let text = quick_xml::escape::unescape(&attribute.value);
                let text = text.map_err(|error| self.fault(error))?;
                if path.replace(text.into_owned()).is_some() {
                    return Err(self.fault("two attributes are a path"));
                }
            }
        }
        Ok(path)
    }
}
