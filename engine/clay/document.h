// SPDX-License-Identifier: MIT
// A document, FILE.clay: the clay and every edit that made it, in an SQLite database.
#pragma once

#include <optional>
#include <vector>

#include "engine/clay/clay_state.h"
#include "engine/clay/database.h"

namespace airclay {

/// An edit that is in the history.
struct HistoryEntry {
  std::string name;              ///< what was done: "New", "Push", "Refine"
  std::int64_t unix_time_s = 0;  ///< when
  bool is_current = false;       ///< the clay is as this edit left it; those after it can be redone
};

/// An open document. What state() gives is what the file holds, always: an edit is one transaction, on the
/// disk when the call returns, and a call that throws has changed neither. So there is nothing to save, a
/// crash costs at most the edit under way, and undo reaches back across restarts, without limit. No other
/// program can open the file meanwhile; nor may this one, past this class: closing a file that was opened by
/// other means drops the process' locks on it (POSIX). One thread at a time.
///
/// \throw Error, from everything here, with the file's name first: it is no document, made by a newer
/// Airclay, damaged, open elsewhere, or cannot be written; the disk is full.
class Document {
 public:
  /// Makes the file; `name` is the first entry's. \throw Error too when there is anything of this name
  /// already, or as checkClayState().
  static Document create(const std::filesystem::path& file, const ClayState& state,
                         const std::string& name = "New");
  /// Opens it where it was left. Everything read is checked, as somebody may have edited it by hand.
  static Document open(const std::filesystem::path& file);

  const std::filesystem::path& file() const { return file_; }
  const ClayState& state() const { return state_; }

  /// Makes `state` the current one; what could be redone is dropped. A state that is bit for bit the current
  /// one makes no entry. \throw Error too as checkClayState(), or when `name` is empty or longer than
  /// kMaxNameBytes.
  void commit(const std::string& name, ClayState state);
  /// `count` entries back or forth, in one transaction. \throw Error too when there are fewer.
  void undo(int count = 1);
  void redo(int count = 1);
  /// The name of the entry that undo() takes back, or redo() brings back; none where there is none.
  std::optional<std::string> canUndo() const;
  std::optional<std::string> canRedo() const;
  int undoCount() const { return static_cast<int>(current_); }
  int redoCount() const { return static_cast<int>(entries_.size() - current_) - 1; }
  /// Oldest first; never empty.
  std::vector<HistoryEntry> history() const;

  /// Copies the document with its history to `file`, whole or not at all, in the place of what is there.
  /// This document stays in its own file: to go on in the copy, open it. Works too when the own file was
  /// deleted meanwhile. \throw Error too when `file` is this document's own file or is open elsewhere.
  void saveAs(const std::filesystem::path& file) const;

  static constexpr int kFormat = 1;  ///< the file's user_version: a larger one is refused
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
  Eigen::Quaterniond loadTurn(const Entry& entry) const;
  std::vector<std::vector<int>> loadFaces(std::int64_t connectivity, std::size_t& point_count) const;
  void goTo(std::size_t entry);
  std::string where(const Entry& entry) const;

  std::filesystem::path file_;
  Database database_;
  std::vector<Entry> entries_;
  std::size_t current_ = 0;  ///< of entries_
  ClayState state_;
  std::int64_t connectivity_ = 0;  ///< the row that holds state_.cage.faces; 0: none yet
};

}  // namespace airclay
