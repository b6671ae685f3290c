//! One or several loaded files.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::error::{DbcError, LookupError, Warning};
use super::load;
use super::lookup::nearest;
use super::message::Message;
use super::signal::Signal;
use super::validate::{Skipped, validate};
use crate::can::CanId;

/// The usable messages of one or several DBC files.
#[derive(Clone, Debug, Default)]
pub struct Database {
    messages: Vec<Message>,
    /// Sorted by identifier.
    by_id: Vec<(CanId, usize)>,
    by_name: HashMap<String, usize>,
    skipped: Vec<Skipped>,
    warnings: Vec<Warning>,
}

impl Database {
    /// Loads a file.
    ///
    /// # Errors
    /// If it cannot be read, is no DBC file, or has no usable message. Anything less is a warning.
    pub fn load(path: &Path) -> Result<Self, DbcError> {
        Self::parse(&load::read(path)?, &path.display().to_string())
    }

    /// Loads several files as one. A message whose identifier or name an earlier file already has is
    /// left out with a warning.
    ///
    /// # Errors
    /// If any of them cannot be used at all.
    pub fn load_all(paths: &[PathBuf]) -> Result<Self, DbcError> {
        let mut all = Self::default();
        for path in paths {
            all.merge(Self::load(path)?);
        }
        Ok(all)
    }

    /// Parses the content of a file; `name` is what warnings and errors call it.
    ///
    /// # Errors
    /// If it is no DBC file or has no usable message.
    pub fn parse(bytes: &[u8], name: &str) -> Result<Self, DbcError> {
        let file: Arc<str> = name.into();
        let valid = validate(load::parse(&load::text(bytes), &file)?, &file);
        if valid.messages.is_empty() {
            let lost = valid.skipped.first().map(|skipped| &skipped.warning);
            return Err(DbcError::NoMessages {
                file: name.to_owned(),
                line: lost.map_or(1, |warning| warning.line),
                reason: lost.map_or("it has no BO_ line".to_owned(), |warning| warning.message.clone()),
            });
        }
        let mut database = Self { skipped: valid.skipped, warnings: valid.warnings, ..Self::default() };
        valid.messages.into_iter().for_each(|message| database.add(message));
        database.sort();
        Ok(database)
    }

    /// Takes over the messages of another file.
    pub fn merge(&mut self, other: Self) {
        self.skipped.extend(other.skipped);
        self.warnings.extend(other.warnings);
        let (taken, new): (Vec<_>, Vec<_>) =
            other.messages.into_iter().partition(|message| self.conflict(message).is_some());
        for message in taken {
            let Some((first, what)) = self.conflict(&message) else { continue };
            let text = format!(
                "message `{}` skipped: its {what} is already taken by `{}` ({}:{})",
                message.name, first.name, first.file, first.line
            );
            let warning = Warning { file: message.file, line: message.line, message: text };
            self.warnings.push(warning.clone());
            self.skipped.push(Skipped { message: message.name, signal: None, warning });
        }
        new.into_iter().for_each(|message| self.add(message));
        self.sort();
    }

    /// The message that already has the identifier or the name, and which of them.
    fn conflict(&self, message: &Message) -> Option<(&Message, String)> {
        let same_id = self.message_with_id(message.id).map(|m| (m, format!("identifier {}", m.id)));
        same_id.or_else(|| Some((self.message(&message.name)?, "name".to_owned())))
    }

    fn add(&mut self, message: Message) {
        self.by_name.insert(message.name.clone(), self.messages.len());
        self.by_id.push((message.id, self.messages.len()));
        self.messages.push(message);
    }

    fn sort(&mut self) {
        self.by_id.sort_unstable();
    }

    /// What was left out and why, file by file, in line order.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// All usable messages, in file order.
    pub fn messages(&self) -> &[Message] {
        &self.messages
    }

    /// The message of this name.
    pub fn message(&self, name: &str) -> Option<&Message> {
        self.by_name.get(name).and_then(|index| self.messages.get(*index))
    }

    /// The message with this identifier.
    pub fn message_with_id(&self, id: CanId) -> Option<&Message> {
        let found = self.by_id.binary_search_by_key(&id, |(id, _)| *id).ok()?;
        self.messages.get(self.by_id.get(found)?.1)
    }

    /// The signal that `MESSAGE.Signal` names.
    ///
    /// # Errors
    /// If there is none: with the nearest names, or with the reason why it was left out.
    pub fn signal(&self, name: &str) -> Result<(&Message, &Signal), LookupError> {
        let (message, signal) =
            name.split_once('.').ok_or_else(|| LookupError::NotQualified(name.to_owned()))?;
        let Some(found) = self.message(message) else {
            return Err(self.missing_message(name, message));
        };
        match found.signal(signal) {
            Some(signal) => Ok((found, signal)),
            None => Err(self.missing_signal(name, found, signal)),
        }
    }

    fn missing_message(&self, name: &str, message: &str) -> LookupError {
        let skipped = self.skipped.iter().find(|s| s.message == message && s.signal.is_none());
        match skipped {
            Some(skipped) => {
                LookupError::Skipped { name: name.to_owned(), reason: skipped.warning.to_string() }
            }
            None => LookupError::UnknownMessage {
                name: message.to_owned(),
                nearest: nearest(message, self.messages.iter().map(|m| m.name.as_str())),
            },
        }
    }

    fn missing_signal(&self, name: &str, message: &Message, signal: &str) -> LookupError {
        let skipped =
            self.skipped.iter().find(|s| s.message == message.name && s.signal.as_deref() == Some(signal));
        if let Some(skipped) = skipped {
            return LookupError::Skipped { name: name.to_owned(), reason: skipped.warning.to_string() };
        }
        let mut similar: Vec<String> = nearest(signal, message.signals.iter().map(|s| s.name.as_str()));
        similar.iter_mut().for_each(|s| *s = format!("{}.{s}", message.name));
        // The right signal may stand in another message.
        let elsewhere = self.messages.iter().filter(|m| m.signal(signal).is_some());
        let elsewhere = elsewhere.take(3).map(|m| format!("{}.{signal}", m.name));
        LookupError::UnknownSignal {
            message: message.name.clone(),
            signal: signal.to_owned(),
            nearest: elsewhere.chain(similar).take(3).collect(),
        }
    }
}
