//! The XML of the parts of a package.

use crate::error::Fault;
use crate::text::decimal;
use quick_xml::Reader;
use quick_xml::events::attributes::Attribute;
use quick_xml::events::{BytesStart, Event};
use std::collections::HashMap;

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

    /// A fault in the line that is being read.
    pub(super) fn fault(&self, what: impl std::fmt::Display) -> Fault {
        let read = self.bytes.get(..self.reader.buffer_position() as usize).unwrap_or_default();
        let line = 1 + read.iter().filter(|&&byte| byte == b'\n').count();
        Fault::line(line, format!("{what} (in {})", self.path))
    }

    fn attributes<'e>(
        &self,
        element: &'e BytesStart<'_>,
    ) -> impl Iterator<Item = Result<Attribute<'e>, Fault>> {
        let mut attributes = element.attributes();
        attributes.with_checks(false);
        attributes.map(|attribute| attribute.map_err(|error| self.fault(error)))
    }

    /// An attribute, as it is written.
    fn raw<'e>(
        &self,
        element: &'e BytesStart<'_>,
        name: &str,
    ) -> Result<Option<Attribute<'e>>, Fault> {
        let is_other = |attribute: &Attribute<'_>| attribute.key.as_ref() != name;
        self.attributes(element).find(|found| !found.as_ref().is_ok_and(is_other)).transpose()
    }

    /// The value of an attribute, with its entities resolved.
    fn unescaped(&self, attribute: &Attribute<'_>) -> Result<String, Fault> {
        let text = quick_xml::escape::unescape(&attribute.value);
        text.map(Into::into).map_err(|error| self.fault(error))
    }

    /// An attribute, unless it is empty.
    pub(super) fn text(
        &self,
        element: &BytesStart<'_>,
        name: &str,
    ) -> Result<Option<String>, Fault> {
        let attribute = self.raw(element, name)?.filter(|attribute| !attribute.value.is_empty());
        attribute.map(|attribute| self.unescaped(&attribute)).transpose()
    }

    /// The number in an attribute that has to be there.
    fn number<T>(
        &self,
        element: &BytesStart<'_>,
        name: &str,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Result<T, Fault> {
        let attribute = self.raw(element, name)?;
        let attribute = attribute.ok_or_else(|| self.fault(format!("{name} is missing")))?;
        let number = parse(attribute.value.trim());
        number.ok_or_else(|| self.fault(format!("{name} is not the number it should be")))
    }

    pub(super) fn natural(&self, element: &BytesStart<'_>, name: &str) -> Result<u32, Fault> {
        self.number(element, name, |text| text.parse().ok())
    }

    pub(super) fn position(&self, element: &BytesStart<'_>) -> Result<[f64; 3], Fault> {
        let axis = |name| self.number(element, name, |text| decimal(text.as_bytes()));
        Ok([axis("x")?, axis("y")?, axis("z")?])
    }

    /// The namespaces that an element declares, by their prefixes.
    pub(super) fn namespaces(
        &self,
        element: &BytesStart<'_>,
    ) -> Result<HashMap<String, String>, Fault> {
        let mut all = HashMap::new();
        for attribute in self.attributes(element) {
            let attribute = attribute?;
            if let Some(prefix) = attribute.key.as_ref().strip_prefix("xmlns:") {
                all.insert(prefix.to_owned(), self.unescaped(&attribute)?);
            }
        }
        Ok(all)
    }

    /// The attribute `path` of the production extension, whatever prefix that has.
    pub(super) fn path(&self, element: &BytesStart<'_>) -> Result<Option<String>, Fault> {
        let mut path = None;
        for attribute in self.attributes(element) {
            let attribute = attribute?;
            let is_path = attribute.key.local_name().as_ref() == "path";
            if is_path && path.replace(self.unescaped(&attribute)?).is_some() {
                return Err(self.fault("two attributes are a path"));
            }
        }
        Ok(path)
    }
}
