// SPDX-License-Identifier: MIT
// The file is an SQLite database (https://sqlite.org/fileformat2.html) with application_id kApplicationId,
// user_version Document::kFormat, and the tables of kSchema. An entry is a complete state, so that undo reads
// one row, however long the history. Each entry has its own control points; consecutive entries refer to the
// same row of faces until an edit changes them. 1,000 strokes on 4,096 control points take 100 MB.
#include "engine/clay/document.h"

#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <limits>
#include <utility>

#include "engine/core/error.h"

namespace airclay {
namespace {

constexpr std::int64_t kApplicationId = 0x41636c79;  // "Acly"

// SQLite's smallest page. SQLite treats a shorter file as a new, empty database.
constexpr std::uintmax_t kMinFileBytes = 512;

constexpr std::int64_t kMaxId = std::numeric_limits<std::int32_t>::max();

constexpr const char* kSchema[] = {
    // Faces as corner count and corners: 32-bit little-endian integers.
    "CREATE TABLE connectivity ("
    " id INTEGER PRIMARY KEY, point_count INTEGER NOT NULL, faces BLOB NOT NULL) STRICT",
    // Points as x, y, z: little-endian doubles; metres, world.
    "CREATE TABLE entry ("
    " id INTEGER PRIMARY KEY, name TEXT NOT NULL, unix_time_s INTEGER NOT NULL,"
    " rule TEXT NOT NULL, levels INTEGER NOT NULL, solve TEXT NOT NULL,"
    " connectivity INTEGER NOT NULL REFERENCES connectivity (id), points BLOB NOT NULL) STRICT",
    "CREATE TABLE document ("
    " id INTEGER PRIMARY KEY CHECK (id = 1),"
    " current_entry INTEGER NOT NULL REFERENCES entry (id)) STRICT",
};

// The rotation of entries whose clay is rotated: a unit quaternion x, y, z, w, little-endian doubles;
// otherwise NULL. The column is added with the first such entry, so that other documents stay readable by
// older versions.
constexpr const char* kAddRotationColumn = "ALTER TABLE entry ADD COLUMN turn BLOB";
constexpr const char* kCountRotationColumns =
    "SELECT count(*) FROM pragma_table_info('entry') WHERE name = 'turn'";

constexpr std::pair<SubdivisionRule, const char*> kRules[] = {
    {SubdivisionRule::kCatmullClark, "catmull-clark"}, {SubdivisionRule::kPrinted, "printed"}};

template <class Value, std::size_t n>
std::string idOf(const std::pair<Value, const char*> (&table)[n], Value value) {
  return std::find_if(table, table + n, [&](const auto& pair) { return pair.first == value; })->second;
}

template <class Value, std::size_t n>
std::optional<Value> valueOf(const std::pair<Value, const char*> (&table)[n], const std::string& id) {
  for (const auto& [value, value_id] : table)
    if (id == value_id) return value;
  return std::nullopt;
}

// Blobs are the in-memory representation of their values.
static_assert(std::endian::native == std::endian::little && sizeof(int) == 4 && sizeof(Vec3) == 24);

template <class Value>
std::vector<Value> valuesOf(std::span<const std::byte> bytes) {
  std::vector<Value> values(bytes.size() / sizeof(Value));
  if (!values.empty())
    std::memcpy(static_cast<void*>(values.data()), bytes.data(), values.size() * sizeof(Value));
  return values;
}

void checkName(const std::string& name, const std::string& where) {
  if (name.empty() || name.size() > Document::kMaxNameBytes)
    throw Error(where + ": the edit's name has " + std::to_string(name.size()) + " bytes; expected 1 to " +
                std::to_string(Document::kMaxNameBytes));
}

void checkFormat(const Database& database, const std::filesystem::path& file) {
  std::error_code ignored;
  const std::uintmax_t bytes = std::filesystem::file_size(file, ignored);
  if (bytes < kMinFileBytes)
    throw Error(file.string() + ": is not an Airclay document, or is truncated to " + std::to_string(bytes) +
                " bytes; expected one created by `airclay new`");
  if (database.number("PRAGMA application_id") != kApplicationId)
    throw Error(file.string() +
                ": is another program's database; expected a document created by `airclay new`");
  const std::int64_t format = database.number("PRAGMA user_version");
  if (format > Document::kFormat)
    throw Error(file.string() + ": was created by a newer Airclay (format " + std::to_string(format) +
                "; this version reads " + std::to_string(Document::kFormat) + "); use the newer version");
  if (format < 1) database.failDamaged("its format is " + std::to_string(format));
}

std::filesystem::path withSuffix(std::filesystem::path file, const std::string& suffix) {
  return file += suffix;
}

/// Deletes the file and the files that SQLite may have left next to it.
void removeDatabase(const std::filesystem::path& file) {
  for (const char* suffix : {"", "-journal", "-wal", "-shm"}) ::unlink(withSuffix(file, suffix).c_str());
}

/// \throw Error unless `file` does not exist or is a regular file that no program has open.
void checkReplaceable(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return;
  if (!std::filesystem::is_regular_file(file, ignored))
    throw Error(file.string() + ": cannot be written: it is not a regular file; use another name");
  if (Database::isOpenElsewhere(file))
    throw Error(file.string() +
                ": is open in another window or program; close it there, or use another name");
}

}  // namespace

Document::Document(std::filesystem::path file, Database database)
    : file_(std::move(file)), database_(std::move(database)) {}

Document Document::create(const std::filesystem::path& file, const ClayState& state,
                          const std::string& name) {
  checkClayState(state, file.string());
  checkName(name, file.string());
  Database database = Database::create(file);
  try {
    Document document(file, std::move(database));
    document.writeFirst({0, std::time(nullptr), name}, state);
    return document;
  } catch (...) {
    removeDatabase(file);
    throw;
  }
}

void Document::writeFirst(Entry entry, const ClayState& state) {
  database_.lock();
  Transaction transaction(database_);
  database_.run(("PRAGMA application_id = " + std::to_string(kApplicationId)).c_str());
  database_.run(("PRAGMA user_version = " + std::to_string(kFormat)).c_str());
  for (const char* table : kSchema) database_.run(table);
  connectivity_ = insertConnectivity(state.cage);
  entry.id = insertEntry(entry, {state, connectivity_});
  Statement(database_, "INSERT INTO document VALUES (1, ?)").bind(1, entry.id).next();
  entries_ = {entry};
  state_ = state;
  transaction.commit();
}

Document Document::open(const std::filesystem::path& file) {
  Document document(file, Database::open(file));
  checkFormat(document.database_, file);
  document.database_.lock();
  document.loadHistory();
  Loaded loaded = document.load(document.entries_[document.current_]);
  document.state_ = std::move(loaded.state);
  document.connectivity_ = loaded.connectivity;
  return document;
}

void Document::commit(const std::string& name, ClayState state) {
  checkName(name, file_.string());
  checkClayState(state, file_.string());
  if (sameClay(state, state_)) return;
  const bool shares_faces =
      state.cage.points.size() == state_.cage.points.size() && state.cage.faces == state_.cage.faces;
  std::vector<Entry> entries(entries_.begin(), entries_.begin() + static_cast<std::ptrdiff_t>(current_) + 1);
  const std::int64_t before = entries.back().id;
  entries.push_back({0, std::time(nullptr), name});

  Transaction transaction(database_);
  if (redoCount() > 0) dropEntriesAfter(before);
  Loaded loaded{std::move(state), shares_faces ? connectivity_ : 0};
  if (!shares_faces) loaded.connectivity = insertConnectivity(loaded.state.cage);
  entries.back().id = insertEntry(entries.back(), loaded);
  setCurrent(entries.back().id);
  transaction.commit();

  entries_ = std::move(entries);
  current_ = entries_.size() - 1;
  state_ = std::move(loaded.state);
  connectivity_ = loaded.connectivity;
}

void Document::undo(int count) {
  if (undoCount() == 0) throw Error(file_.string() + ": there is nothing to undo");
  if (count < 1 || count > undoCount())
    throw Error(file_.string() + ": " + std::to_string(count) + " edits cannot be undone; there are " +
                std::to_string(undoCount()) + " to undo");
  goTo(current_ - static_cast<std::size_t>(count));
}

void Document::redo(int count) {
  if (redoCount() == 0) throw Error(file_.string() + ": there is nothing to redo");
  if (count < 1 || count > redoCount())
    throw Error(file_.string() + ": " + std::to_string(count) + " edits cannot be redone; there are " +
                std::to_string(redoCount()) + " to redo");
  goTo(current_ + static_cast<std::size_t>(count));
}

std::optional<std::string> Document::canUndo() const {
  if (undoCount() == 0) return std::nullopt;
  return entries_[current_].name;
}

std::optional<std::string> Document::canRedo() const {
  if (redoCount() == 0) return std::nullopt;
  return entries_[current_ + 1].name;
}

std::vector<HistoryEntry> Document::history() const {
  std::vector<HistoryEntry> history;
  for (const Entry& entry : entries_) history.push_back({entry.name, entry.unix_time_s, false});
  history[current_].is_current = true;
  return history;
}

void Document::saveAs(const std::filesystem::path& file) const {
  std::error_code ignored;
  if (std::filesystem::equivalent(file, file_, ignored))
    throw Error(file.string() +
                ": is this document's own file, which already contains every edit; use another name");
  checkReplaceable(file);
  // For a symbolic link, replace its target and keep the link.
  const std::filesystem::path target =
      std::filesystem::is_symlink(file, ignored) ? std::filesystem::weakly_canonical(file, ignored) : file;
  const std::filesystem::path temporary =
      std::filesystem::absolute(withSuffix(target, ".part-" + std::to_string(::getpid())));
  removeDatabase(temporary);
  try {
    database_.copyTo(temporary, file.string());
    // SQLite would apply a journal of the replaced file to the copy.
    for (const char* suffix : {"-journal", "-wal", "-shm"}) ::unlink(withSuffix(target, suffix).c_str());
    if (::rename(temporary.c_str(), target.c_str()) != 0)
      throw Error(file.string() + ": cannot be written: " + std::strerror(errno));
    Database::syncToDisk(temporary.parent_path(), file.string());
  } catch (...) {
    removeDatabase(temporary);
    throw;
  }
}

std::int64_t Document::insertConnectivity(const PolygonMesh& cage) {
  std::vector<int> faces;
  for (const std::vector<int>& face : cage.faces) {
    faces.push_back(static_cast<int>(face.size()));
    faces.insert(faces.end(), face.begin(), face.end());
  }
  Statement insert(database_, "INSERT INTO connectivity (point_count, faces) VALUES (?, ?)");
  insert.bind(1, static_cast<std::int64_t>(cage.points.size())).bind(2, std::as_bytes(std::span(faces)));
  insert.next();
  return database_.number("SELECT last_insert_rowid()");
}

std::int64_t Document::insertEntry(const Entry& entry, const Loaded& loaded) {
  Statement insert(database_,
                   "INSERT INTO entry (name, unix_time_s, rule, levels, solve, connectivity, points) "
                   "VALUES (?, ?, ?, ?, ?, ?, ?)");
  insert.bind(1, std::string_view(entry.name))
      .bind(2, entry.unix_time_s)
      .bind(3, std::string_view(idOf(kRules, loaded.state.rule)))
      .bind(4, static_cast<std::int64_t>(loaded.state.levels))
      .bind(5, std::string_view(loaded.state.solve->id))
      .bind(6, loaded.connectivity)
      .bind(7, std::as_bytes(std::span(loaded.state.cage.points)));
  insert.next();
  const std::int64_t id = database_.number("SELECT last_insert_rowid()");
  const Eigen::Vector4d& rotation = loaded.state.workspace_from_clay.coeffs();
  if (rotation != Eigen::Quaterniond::Identity().coeffs()) {
    if (database_.number(kCountRotationColumns) == 0) database_.run(kAddRotationColumn);
    Statement update(database_, "UPDATE entry SET turn = ? WHERE id = ?");
    update.bind(1, std::as_bytes(std::span(rotation.data(), 4))).bind(2, id).next();
  }
  return id;
}

void Document::setCurrent(std::int64_t entry) {
  Statement(database_, "UPDATE document SET current_entry = ?").bind(1, entry).next();
}

void Document::dropEntriesAfter(std::int64_t entry) {
  Statement(database_, "DELETE FROM entry WHERE id > ?").bind(1, entry).next();
  database_.run("DELETE FROM connectivity WHERE id NOT IN (SELECT connectivity FROM entry)");
}

void Document::loadHistory() {
  const std::int64_t current = database_.number("SELECT current_entry FROM document");
  std::optional<std::size_t> found;
  Statement select(database_, "SELECT id, unix_time_s, name FROM entry ORDER BY id");
  while (select.next()) {
    entries_.push_back({select.number(0), select.number(1), select.text(2)});
    const std::string& name = entries_.back().name;
    if (name.empty() || name.size() > kMaxNameBytes) database_.failDamaged("a name's length");
    // Near the largest id, SQLite no longer assigns ids in ascending order.
    if (entries_.back().id < 1 || entries_.back().id > kMaxId) database_.failDamaged("an entry's number");
    if (entries_.back().id == current) found = entries_.size() - 1;
  }
  if (!found) database_.failDamaged("the current entry is missing");
  current_ = *found;
}

std::string Document::where(const Entry& entry) const {
  return file_.string() + ": entry " + std::to_string(entry.id);
}

Document::Loaded Document::load(const Entry& entry) const {
  Statement select(database_, "SELECT rule, levels, solve, connectivity, points FROM entry WHERE id = ?");
  if (!select.bind(1, entry.id).next())
    database_.failDamaged("entry " + std::to_string(entry.id) + " is missing");
  const std::optional<SubdivisionRule> rule = valueOf(kRules, select.text(0));
  const SolveMethod* solve = findSolveMethod(select.text(2));
  if (!rule || !solve)
    throw Error(where(entry) + " has an unknown " +
                (rule ? "solve; expected " + solveMethodIds() : "rule; expected catmull-clark or printed"));
  Loaded loaded;
  loaded.state.rule = *rule;
  loaded.state.solve = solve;
  loaded.state.levels = static_cast<int>(std::clamp<std::int64_t>(select.number(1), 0, kMaxStateLevels + 1));
  loaded.connectivity = select.number(3);
  // Strokes do not change faces: reuse the current ones if the row is the same.
  std::size_t point_count = state_.cage.points.size();
  loaded.state.cage.faces =
      loaded.connectivity == connectivity_ ? state_.cage.faces : loadFaces(loaded.connectivity, point_count);
  const std::span<const std::byte> points = select.bytes(4);
  if (points.size() != point_count * sizeof(Vec3))
    throw Error(where(entry) + " has " + std::to_string(points.size()) +
                " bytes of control points; expected " + std::to_string(point_count * sizeof(Vec3)));
  loaded.state.cage.points = valuesOf<Vec3>(points);
  loaded.state.workspace_from_clay = loadRotation(entry);
  checkClayState(loaded.state, where(entry));
  return loaded;
}

Eigen::Quaterniond Document::loadRotation(const Entry& entry) const {
  if (database_.number(kCountRotationColumns) == 0) return Eigen::Quaterniond::Identity();
  Statement select(database_, "SELECT turn FROM entry WHERE id = ? AND turn IS NOT NULL");
  if (!select.bind(1, entry.id).next()) return Eigen::Quaterniond::Identity();
  const std::vector<double> values = valuesOf<double>(select.bytes(0));
  if (values.size() != 4)
    throw Error(where(entry) + " has " + std::to_string(values.size()) +
                " numbers in the clay's rotation; expected 4");
  return Eigen::Quaterniond(Eigen::Vector4d(values.data()));
}

std::vector<std::vector<int>> Document::loadFaces(std::int64_t connectivity, std::size_t& point_count) const {
  Statement select(database_, "SELECT point_count, faces FROM connectivity WHERE id = ?");
  if (!select.bind(1, connectivity).next())
    database_.failDamaged("connectivity " + std::to_string(connectivity) + " is missing");
  const std::int64_t count = select.number(0);
  if (count < 1 || count > static_cast<std::int64_t>(kMaxStatePoints))
    database_.failDamaged("a cage of " + std::to_string(count) + " points");
  point_count = static_cast<std::size_t>(count);
  const std::span<const std::byte> bytes = select.bytes(1);
  if (bytes.size() % sizeof(int) != 0)
    database_.failDamaged("faces of " + std::to_string(bytes.size()) + " bytes");
  const std::vector<int> values = valuesOf<int>(bytes);
  std::vector<std::vector<int>> faces;
  for (std::size_t at = 0; at < values.size();) {
    const int corners = values[at++];
    if (corners < 3 || static_cast<std::size_t>(corners) > values.size() - at)
      database_.failDamaged("a face of " + std::to_string(corners) + " corners");
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(at);
    faces.emplace_back(first, first + corners);
    at += static_cast<std::size_t>(corners);
  }
  return faces;
}

void Document::goTo(std::size_t entry) {
  Loaded loaded = load(entries_[entry]);
  Transaction transaction(database_);
  setCurrent(entries_[entry].id);
  transaction.commit();
  current_ = entry;
  state_ = std::move(loaded.state);
  connectivity_ = loaded.connectivity;
}

}  // namespace airclay
