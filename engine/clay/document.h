// SPDX-License-Identifier: MIT
// A document, FILE.clay: the clay and its complete edit history, in an SQLite database.
#pragma once

#include <optional>
#include <vector>

#include "engine/clay/clay_state.h"
#include "engine/clay/database.h"

namespace airclay {

/// One edit in the history.
struct HistoryEntry {
  std::string name;              ///< "New", "Push", "Refine"
  std::int64_t unix_time_s = 0;  ///< time of the edit
  bool is_current = false;       ///< state() is the result of this edit; later entries can be redone
};

/// An open document. state() always equals the file's content: an edit is one transaction, which is on the
/// disk when the call returns; a call that throws changes neither. There is no save command, a crash loses at
/// most the edit in progress, and undo is unlimited, across restarts too. Other programs cannot open the file
/// meanwhile. This program must not open it by other means: closing any descriptor of the file releases the
/// process's locks on it (POSIX). Not thread-safe.
///
/// \throw Error, from every function, starting with the file's name, if the file is not a document, is from a
/// newer Airclay, is damaged, open elsewhere or not writable, or if the disk is full.
class Document {
 public:
  /// Creates the file with one history entry, `name`. \throw Error also if the file exists, and like
  /// checkClayState().
  static Document create(const std::filesystem::path& file, const ClayState& state,
                         const std::string& name = "New");
  /// Opens a document at its current entry. Checks everything it reads, because the file may have been edited
  /// by hand.
  static Document open(const std::filesystem::path& file);

  const std::filesystem::path& file() const { return file_; }
  const ClayState& state() const { return state_; }

  /// Appends `state` to the history and discards the entries that could be redone. Does nothing if `state`
  /// equals the current state bit for bit. \throw Error also if `name` is empty or longer than kMaxNameBytes,
  /// and like checkClayState().
  void commit(const std::string& name, ClayState state);
  /// Moves `count` entries back or forward, in one transaction. \throw Error also if there are fewer.
  void undo(int count = 1);
  void redo(int count = 1);
  /// The name of the entry that undo() or redo() would affect; empty if there is none.
  std::optional<std::string> canUndo() const;
  std::optional<std::string> canRedo() const;
  int undoCount() const { return static_cast<int>(current_); }
  int redoCount() const { return static_cast<int>(entries_.size() - current_) - 1; }
  /// Oldest first; never empty.
  std::vector<HistoryEntry> history() const;

  /// Copies the document with its history to `file`, atomically, and replaces an existing file. This document
  /// keeps its own file; to continue in the copy, open it. Also works if the own file was deleted. \throw
  /// Error also if `file` is this document's own file or is open elsewhere.
  void saveAs(const std::filesystem::path& file) const;

  static constexpr int kFormat = 1;  ///< the file's user_version; larger versions are rejected
  static constexpr std::size_t kMaxNameBytes = 200;

 private:
  struct Entry {
    std::int64_t id = 0, unix_time_s = 0;
    std::string name;
  };
  /// A state and the row of its connectivity.
  struct Loaded {
    ClayState state;
    std::int64_t connectivity = 0;
  };

  Document(std::filesystem::path file, Database database);
  void writeFirst(Entry entry, const ClayState& state);
  std::int64_t insertConnectivity(const PolygonMesh& cage);
  std::int64_t insertEntry(const Entry& entry, const Loaded& loaded);
  void setCurrent(std::int64_t entry);
  void dropEntriesAfter(std::int64_t entry);
  void loadHistory();
  Loaded load(const Entry& entry) const;
  Eigen::Quaterniond loadRotation(const Entry& entry) const;
  std::vector<std::vector<int>> loadFaces(std::int64_t connectivity, std::size_t& point_count) const;
  void goTo(std::size_t entry);
  std::string where(const Entry& entry) const;

  std::filesystem::path file_;
  Database database_;
  std::vector<Entry> entries_;
  std::size_t current_ = 0;  ///< of entries_
  ClayState state_;
  std::int64_t connectivity_ = 0;  ///< the row that contains state_.cage.faces; 0: none yet
};

}  // namespace airclay
