// SPDX-License-Identifier: MIT
// A thin SQLite wrapper for documents: one file, one program, and a one-line message for every error.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace airclay {

/// A database file, locked exclusively from lock() until destruction. Uses a rollback journal with full
/// syncs: a committed transaction is on the disk, an uncommitted one leaves no trace. Every function throws
/// Error, starting with the file's name, if the file is not a database, is damaged or truncated, is open
/// elsewhere, or cannot be read or written, or if the disk is full.
class Database {
 public:
  /// Opens an existing file, which is not trusted: its triggers and views do not run, and values above
  /// kMaxValueBytes are not read. Does not lock the file yet, so that other programs' files stay untouched.
  static Database open(const std::filesystem::path& file);
  /// Creates an empty file and opens it. \throw Error if the name exists.
  static Database create(const std::filesystem::path& file);
  /// Whether another program has the file open as a database. Rolls back a transaction that a crashed program
  /// left unfinished.
  static bool isOpenElsewhere(const std::filesystem::path& file);

  /// Locks the file against other programs until destruction.
  void lock();
  /// Runs one statement without parameters or results.
  void run(const char* sql);
  /// The single integer that a query returns.
  std::int64_t number(const char* sql) const;
  /// \throw Error if the file was renamed or deleted, so that further writes would be lost.
  void checkNotMoved() const;

  /// Copies the database, without deleted rows, to a new file and syncs it. \throw Error starting with
  /// `name`, the copy's name for the user.
  void copyTo(const std::filesystem::path& file, const std::string& name) const;
  /// Calls fsync on the file or folder. \throw Error starting with `name`
  static void syncToDisk(const std::filesystem::path& file_or_folder, const std::string& name);

  /// The path as passed to open() or create().
  const std::string& name() const { return name_; }
  sqlite3* get() const { return connection_.get(); }
  /// Throws the Error for an SQLite result code.
  [[noreturn]] void fail(int code) const { fail(code, name_); }
  /// Throws the Error for content that Airclay did not write.
  [[noreturn]] void failDamaged(const std::string& what) const;

  static constexpr int kMaxValueBytes = 128 << 20;  ///< 5 million control points are 120 MB

 private:
  struct Closer {
    void operator()(sqlite3* connection) const;
  };
  explicit Database(const std::filesystem::path& file);
  [[noreturn]] void fail(int code, const std::string& name) const;

  std::string name_;
  std::unique_ptr<sqlite3, Closer> connection_;
};

/// A prepared statement. Parameters count from 1 and columns from 0, as in SQLite.
class Statement {
 public:
  Statement(const Database& database, const char* sql);

  Statement& bind(int parameter, std::int64_t number);
  Statement& bind(int parameter, std::string_view text);
  /// \pre the bytes stay unchanged until the last next()
  Statement& bind(int parameter, std::span<const std::byte> bytes);

  /// Advances to the next row; false at the end, or if the statement returns no rows.
  bool next();
  /// A column of the current row. \throw Error if it has another type, which Airclay does not write.
  std::int64_t number(int column) const;
  std::string text(int column) const;
  std::span<const std::byte> bytes(int column) const;  ///< valid until next()

 private:
  struct Closer {
    void operator()(sqlite3_stmt* statement) const;
  };
  void checkType(int column, int type) const;

  const Database& database_;
  std::unique_ptr<sqlite3_stmt, Closer> statement_;
};

/// Makes all writes until commit() atomic; rolls back on destruction without commit().
class Transaction {
 public:
  /// \throw Error like Database::checkNotMoved().
  explicit Transaction(Database& database);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  /// On return, everything is on the disk. \throw Error if it fails; then nothing has changed.
  void commit();

 private:
  Database& database_;
};

}  // namespace airclay
