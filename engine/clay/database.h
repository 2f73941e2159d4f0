// SPDX-License-Identifier: MIT
// SQLite as a document needs it: one file, one program, and every fault a line that says what to do.
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

/// A database file that this connection alone has open, until it is destroyed. A rollback journal with full
/// syncs: a transaction that was committed has reached the disk, one that was not leaves no trace.
/// Everything throws Error with the file's name first: when it is no database, is damaged or cut short, is
/// open elsewhere, cannot be read or written, or the disk is full.
class Database {
 public:
  /// Opens an existing file. Nothing in it is believed: no trigger or view of it runs, and no value of more
  /// than kMaxValueBytes is read. Not locked yet, so that a file of another program is left alone.
  static Database open(const std::filesystem::path& file);
  /// Makes an empty file and opens it. \throw Error when there is anything of this name.
  static Database create(const std::filesystem::path& file);
  /// Whether another program has the file open as a database. What that program left of an unfinished
  /// transaction, if it died, is rolled back.
  static bool isOpenElsewhere(const std::filesystem::path& file);

  /// Keeps every other program out from now on.
  void lock();
  /// One statement without parameters and results.
  void run(const char* sql);
  /// The one whole number that a statement gives.
  std::int64_t number(const char* sql) const;
  /// \throw Error when the file has another name now or was deleted: what would be written to it is lost.
  void checkInPlace() const;

  /// Copies all but what was deleted into a new file, and to the disk. \throw Error that begins with `name`,
  /// the copy's as the user knows it.
  void copyTo(const std::filesystem::path& file, const std::string& name) const;
  /// What SQLite or rename() left to the system is on the disk when this returns.
  static void syncToDisk(const std::filesystem::path& file_or_folder, const std::string& name);

  /// As it was given.
  const std::string& name() const { return name_; }
  sqlite3* get() const { return connection_.get(); }
  /// Throws the Error that fits SQLite's result code.
  [[noreturn]] void fail(int code) const { fail(code, name_); }
  /// Throws the Error of a file whose content is not as Airclay writes it.
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

/// A statement under way. Parameters are counted from 1, columns from 0, as SQLite does.
class Statement {
 public:
  Statement(const Database& database, const char* sql);

  Statement& bind(int parameter, std::int64_t number);
  Statement& bind(int parameter, std::string_view text);
  /// \pre the bytes stay as they are until the last next()
  Statement& bind(int parameter, std::span<const std::byte> bytes);

  /// To the next row; false at the end, and with a statement that gives none.
  bool next();
  /// A column of this row. \throw Error when it is of another type: somebody else wrote it.
  std::int64_t number(int column) const;
  std::string text(int column) const;
  std::span<const std::byte> bytes(int column) const;  ///< until next()

 private:
  struct Closer {
    void operator()(sqlite3_stmt* statement) const;
  };
  void checkType(int column, int type) const;

  const Database& database_;
  std::unique_ptr<sqlite3_stmt, Closer> statement_;
};

/// What is written between here and commit() is written whole or not at all.
class Transaction {
 public:
  /// \throw Error as Database::checkInPlace().
  explicit Transaction(Database& database);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  /// When it returns, all is on the disk. \throw Error and nothing is changed.
  void commit();

 private:
  Database& database_;
};

}  // namespace airclay
