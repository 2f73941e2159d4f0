// SPDX-License-Identifier: MIT
// Built on SQLite 3 (https://sqlite.org/c3ref/intro.html). The precautions against untrusted files follow its
// "Defense Against The Dark Arts" (https://sqlite.org/security.html).
//
// Uses a rollback journal instead of write-ahead logging: between two edits, FILE.clay alone is the whole
// document, even after a crash, so it can be copied, mailed and backed up while it is open. Write-ahead
// logging would save three of four syncs per edit (measured: 1.4 ms instead of 4 ms), but leave finished
// edits in a second file that users lose.
#include "engine/clay/database.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <new>

#include "engine/core/error.h"

namespace airclay {
namespace {

// Half a second: long enough for a command that is just ending; a window keeps the file open.
constexpr int kBusyTimeout_ms = 500;

/// Opens a connection. SQLite does not read the file yet.
sqlite3* connect(const std::filesystem::path& file) {
  sqlite3* connection = nullptr;
  // Absolute, so that SQLite does not interpret the name as a URI or an in-memory database.
  const int code = sqlite3_open_v2(std::filesystem::absolute(file).c_str(), &connection,
                                   SQLITE_OPEN_READWRITE | SQLITE_OPEN_EXRESCODE, nullptr);
  if (!connection) throw std::bad_alloc();
  if (code == SQLITE_OK) return connection;
  const int system = sqlite3_system_errno(connection);
  const std::string reason = system ? std::strerror(system) : sqlite3_errmsg(connection);
  sqlite3_close_v2(connection);
  throw Error(file.string() + ": cannot be opened: " + reason);
}

}  // namespace

void Database::Closer::operator()(sqlite3* connection) const {
  sqlite3_close_v2(connection);
}

Database::Database(const std::filesystem::path& file) : name_(file.string()), connection_(connect(file)) {
  sqlite3_busy_timeout(get(), kBusyTimeout_ms);
  sqlite3_limit(get(), SQLITE_LIMIT_LENGTH, kMaxValueBytes);
  sqlite3_db_config(get(), SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(get(), SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(get(), SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(get(), SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  run("PRAGMA cell_size_check = ON");
  run("PRAGMA mmap_size = 0");
}

Database Database::open(const std::filesystem::path& file) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (status.type() == std::filesystem::file_type::not_found)
    throw Error(file.string() + ": there is no such file; `airclay new` creates one");
  if (error) throw Error(file.string() + ": cannot be opened: " + error.message());
  if (!std::filesystem::is_regular_file(status))
    throw Error(file.string() + ": is not a file; expected a document created by `airclay new`");
  Database database(file);
  // SQLite opens a write-protected file for reading, and the journal requires a writable folder.
  const std::filesystem::path canonical = std::filesystem::canonical(file, error);
  if (sqlite3_db_readonly(database.get(), "main") == 1)
    throw Error(file.string() + ": is write-protected; use a copy that can be written");
  if (::faccessat(AT_FDCWD, canonical.parent_path().c_str(), W_OK | X_OK, AT_EACCESS) != 0)
    throw Error(file.string() + ": its folder cannot be written (" + std::strerror(errno) +
                "), which every edit requires; use a copy in a writable folder");
  return database;
}

Database Database::create(const std::filesystem::path& file) {
  // Exclusive, so that an existing file stays untouched.
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0)
    throw Error(file.string() + (errno == EEXIST
                                     ? ": already exists; use another name"
                                     : ": cannot be written: " + std::string(std::strerror(errno)) +
                                           "; use a file in a writable folder"));
  ::close(descriptor);
  return Database(file);
}

bool Database::isOpenElsewhere(const std::filesystem::path& file) {
  const Database database(file);
  char* message = nullptr;
  const int code = sqlite3_exec(database.get(), "BEGIN EXCLUSIVE; COMMIT", nullptr, nullptr, &message);
  sqlite3_free(message);
  return (code & 0xff) == SQLITE_BUSY;
}

void Database::lock() {
  run("PRAGMA locking_mode = EXCLUSIVE");
  run("PRAGMA journal_mode = DELETE");
  run("PRAGMA synchronous = FULL");
  // In this mode the connection keeps a lock once it has acquired it.
  run("BEGIN EXCLUSIVE");
  run("COMMIT");
}

void Database::run(const char* sql) {
  Statement statement(*this, sql);
  while (statement.next()) continue;
}

std::int64_t Database::number(const char* sql) const {
  Statement statement(*this, sql);
  if (!statement.next()) failDamaged("something is missing");
  return statement.number(0);
}

void Database::checkNotMoved() const {
  int moved = 0;
  sqlite3_file_control(get(), "main", SQLITE_FCNTL_HAS_MOVED, &moved);
  if (moved)
    throw Error(
        name_ +
        ": was moved or deleted while it was open, so nothing more is written to it; save the clay under a "
        "new name to keep it");
}

void Database::copyTo(const std::filesystem::path& file, const std::string& name) const {
  sqlite3_stmt* statement = nullptr;
  int code = sqlite3_prepare_v2(get(), "VACUUM INTO ?", -1, &statement, nullptr);
  const std::string path = std::filesystem::absolute(file).string();
  if (code == SQLITE_OK) code = sqlite3_bind_text(statement, 1, path.c_str(), -1, SQLITE_STATIC);
  if (code == SQLITE_OK) code = sqlite3_step(statement);
  sqlite3_finalize(statement);
  if (code != SQLITE_DONE) fail(code, (code & 0xff) == SQLITE_CORRUPT ? name_ : name);
  syncToDisk(file, name);  // SQLite does not sync it: after a power failure the copy could be empty
}

void Database::syncToDisk(const std::filesystem::path& file_or_folder, const std::string& name) {
  const int descriptor = ::open(file_or_folder.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = descriptor >= 0 && ::fsync(descriptor) == 0;
  const std::string reason = std::strerror(errno);
  if (descriptor >= 0) ::close(descriptor);
  if (!synced) throw Error(name + ": cannot be written: " + reason);
}

void Database::fail(int code, const std::string& name) const {
  const bool asked_system = (code & 0xff) == SQLITE_IOERR || (code & 0xff) == SQLITE_CANTOPEN;
  const int system = asked_system ? sqlite3_system_errno(get()) : 0;
  const std::string detail = sqlite3_errmsg(get());
  const std::string reason = system ? std::strerror(system) : detail;
  const bool writing_failed = (code & 0xff) == SQLITE_IOERR && (system == ENOSPC || system == EDQUOT);
  if ((code & 0xff) == SQLITE_FULL || writing_failed)
    throw Error(name + ": the disk is full, so nothing was written; free some space and try again");
  if (code == SQLITE_READONLY_DIRECTORY)
    throw Error(name + ": cannot be written: its folder is write-protected; use a writable folder");
  switch (code & 0xff) {
    case SQLITE_NOMEM:
      throw std::bad_alloc();
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      throw Error(name + ": is open in another window or program; close it there first");
    case SQLITE_NOTADB:
      throw Error(name + ": is not an Airclay document; expected one created by `airclay new`");
    case SQLITE_CANTOPEN:
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_AUTH:
      throw Error(name + ": cannot be written: " + reason + "; use a file in a writable folder");
    case SQLITE_IOERR:
      throw Error(name + ": cannot be read or written: " + reason +
                  "; nothing was changed; use another disk");
    default:
      failDamaged(detail);
  }
}

void Database::failDamaged(const std::string& what) const {
  throw Error(name_ + ": is damaged or truncated (" + what + "); use an intact copy");
}

void Statement::Closer::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

Statement::Statement(const Database& database, const char* sql) : database_(database) {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v2(database.get(), sql, -1, &statement, nullptr);
  statement_.reset(statement);
  if (code != SQLITE_OK) database.fail(code);
}

Statement& Statement::bind(int parameter, std::int64_t number) {
  const int code = sqlite3_bind_int64(statement_.get(), parameter, number);
  if (code != SQLITE_OK) database_.fail(code);
  return *this;
}

Statement& Statement::bind(int parameter, std::string_view text) {
  const int code = sqlite3_bind_text64(statement_.get(), parameter, text.data(), text.size(),
                                       SQLITE_TRANSIENT, SQLITE_UTF8);
  if (code != SQLITE_OK) database_.fail(code);
  return *this;
}

Statement& Statement::bind(int parameter, std::span<const std::byte> bytes) {
  const int code =
      sqlite3_bind_blob64(statement_.get(), parameter, bytes.data(), bytes.size(), SQLITE_STATIC);
  if (code != SQLITE_OK) database_.fail(code);
  return *this;
}

bool Statement::next() {
  const int code = sqlite3_step(statement_.get());
  if (code != SQLITE_ROW && code != SQLITE_DONE) database_.fail(code);
  return code == SQLITE_ROW;
}

void Statement::checkType(int column, int type) const {
  if (sqlite3_column_type(statement_.get(), column) != type)
    database_.failDamaged(std::string("column ") + sqlite3_column_name(statement_.get(), column) +
                          " has the wrong type");
}

std::int64_t Statement::number(int column) const {
  checkType(column, SQLITE_INTEGER);
  return sqlite3_column_int64(statement_.get(), column);
}

std::string Statement::text(int column) const {
  checkType(column, SQLITE_TEXT);
  const unsigned char* text = sqlite3_column_text(statement_.get(), column);
  if (!text) throw std::bad_alloc();
  return {reinterpret_cast<const char*>(text),
          static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

std::span<const std::byte> Statement::bytes(int column) const {
  checkType(column, SQLITE_BLOB);
  const void* bytes = sqlite3_column_blob(statement_.get(), column);
  const int size = sqlite3_column_bytes(statement_.get(), column);
  if (!bytes && size > 0) throw std::bad_alloc();
  return {static_cast<const std::byte*>(bytes), static_cast<std::size_t>(size)};
}

Transaction::Transaction(Database& database) : database_(database) {
  database.checkNotMoved();
  database.run("BEGIN IMMEDIATE");
}

Transaction::~Transaction() {
  // After some errors SQLite has already rolled back. If the rollback fails, SQLite repeats it when the file
  // is next opened.
  if (!sqlite3_get_autocommit(database_.get()))
    sqlite3_exec(database_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::commit() {
  database_.run("COMMIT");
}

}  // namespace airclay
