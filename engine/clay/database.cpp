// SPDX-License-Identifier: MIT
// Over SQLite 3 (https://sqlite.org/c3ref/intro.html). What is done against files of strangers follows its
// "Defense Against The Dark Arts" (https://sqlite.org/security.html).
//
// A rollback journal, not write-ahead logging: between two edits FILE.clay alone is the whole document, also
// after a crash, so it can be copied, mailed and backed up while it is open. A log would save three of four
// syncs an edit (4 ms became 1.4 ms where this was tried), but leave finished edits in a second file that
// gets lost.
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

// Half a second: a command that is just ending lets go of the file; a window doesn't.
constexpr int kPatienceMs = 500;

/// Opened without a complaint of its own; SQLite reads nothing yet.
sqlite3* connect(const std::filesystem::path& file) {
  sqlite3* connection = nullptr;
  // Absolute, so that no name is taken for a URI or for a database in memory.
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
  sqlite3_busy_timeout(get(), kPatienceMs);
  sqlite3_limit(get(), SQLITE_LIMIT_LENGTH, kMaxValueBytes);
  sqlite3_db_config(get(), SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(get(), SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(get(), SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(get(), SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  run("PRAGMA cell_size_check = ON");
  run("PRAGMA mmap_size = 0");
}

Database Database::open(const std::filesystem::path& file) {
  std::error_code fault;
  const std::filesystem::file_status status = std::filesystem::status(file, fault);
  if (status.type() == std::filesystem::file_type::not_found)
    throw Error(file.string() + ": there is no such file; `airclay new` makes one");
  if (fault) throw Error(file.string() + ": cannot be opened: " + fault.message());
  if (!std::filesystem::is_regular_file(status))
    throw Error(file.string() + ": is no file; a document that `airclay new` made would be right");
  Database database(file);
  // SQLite opens for reading what may not be written, and a journal needs the folder.
  const std::filesystem::path whole = std::filesystem::canonical(file, fault);
  if (sqlite3_db_readonly(database.get(), "main") == 1)
    throw Error(file.string() + ": may not be written; a copy of it that may be would be right");
  if (::faccessat(AT_FDCWD, whole.parent_path().c_str(), W_OK | X_OK, AT_EACCESS) != 0)
    throw Error(file.string() + ": its folder cannot be written (" + std::strerror(errno) +
                "), which every edit needs; a copy in a folder that can be would be right");
  return database;
}

Database Database::create(const std::filesystem::path& file) {
  // Exclusively: whatever has the name already stays untouched.
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0)
    throw Error(file.string() + (errno == EEXIST
                                     ? ": exists already; a new name would be right"
                                     : ": cannot be written: " + std::string(std::strerror(errno)) +
                                           "; name a file in a folder that can be"));
  ::close(descriptor);
  return Database(file);
}

bool Database::isOpenElsewhere(const std::filesystem::path& file) {
  const Database database(file);
  char* complaint = nullptr;
  const int code = sqlite3_exec(database.get(), "BEGIN EXCLUSIVE; COMMIT", nullptr, nullptr, &complaint);
  sqlite3_free(complaint);
  return (code & 0xff) == SQLITE_BUSY;
}

void Database::lock() {
  run("PRAGMA locking_mode = EXCLUSIVE");
  run("PRAGMA journal_mode = DELETE");
  run("PRAGMA synchronous = FULL");
  // In this mode a lock that was taken once is kept.
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

void Database::checkInPlace() const {
  int moved = 0;
  sqlite3_file_control(get(), "main", SQLITE_FCNTL_HAS_MOVED, &moved);
  if (moved)
    throw Error(
        name_ +
        ": was moved or deleted while it was open, and nothing more is written to it; saving the clay "
        "under a new name keeps it");
}

void Database::copyTo(const std::filesystem::path& file, const std::string& name) const {
  sqlite3_stmt* statement = nullptr;
  int code = sqlite3_prepare_v2(get(), "VACUUM INTO ?", -1, &statement, nullptr);
  const std::string path = std::filesystem::absolute(file).string();
  if (code == SQLITE_OK) code = sqlite3_bind_text(statement, 1, path.c_str(), -1, SQLITE_STATIC);
  if (code == SQLITE_OK) code = sqlite3_step(statement);
  sqlite3_finalize(statement);
  if (code != SQLITE_DONE) fail(code, (code & 0xff) == SQLITE_CORRUPT ? name_ : name);
  syncToDisk(file, name);  // SQLite doesn't: after a power cut the copy could be empty
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
    throw Error(name + ": the disk is full, so nothing was written; free some space, then try again");
  if (code == SQLITE_READONLY_DIRECTORY)
    throw Error(name + ": cannot be written: its folder may not be; one that may be would be right");
  switch (code & 0xff) {
    case SQLITE_NOMEM:
      throw std::bad_alloc();
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      throw Error(name + ": is open in another window or program; close it there first");
    case SQLITE_NOTADB:
      throw Error(name + ": is no Airclay document; one that `airclay new` made would be right");
    case SQLITE_CANTOPEN:
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_AUTH:
      throw Error(name + ": cannot be written: " + reason +
                  "; a file in a folder that can be would be right");
    case SQLITE_IOERR:
      throw Error(name + ": cannot be read or written: " + reason +
                  "; nothing was changed, another disk would be right");
    default:
      failDamaged(detail);
  }
}

void Database::failDamaged(const std::string& what) const {
  throw Error(name_ + ": is damaged or was cut short (" + what + "); a whole copy of it would be right");
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
                          " is of another type");
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
  database.checkInPlace();
  database.run("BEGIN IMMEDIATE");
}

Transaction::~Transaction() {
  // After some faults SQLite has rolled back by itself. A rollback that fails is done when the file is next
  // opened.
  if (!sqlite3_get_autocommit(database_.get()))
    sqlite3_exec(database_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::commit() {
  database_.run("COMMIT");
}

}  // namespace airclay
