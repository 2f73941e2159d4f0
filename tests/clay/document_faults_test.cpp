// SPDX-License-Identifier: MIT
// Invalid and damaged documents, full disks and read-only folders: one error line, and no data
// lost. Damage comes from SQLite, from system limits and permissions, or byte by byte.
#include <gtest/gtest.h>
#include <signal.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <random>

#include "engine/clay/document.h"
#include "engine/clay/refine.h"
#include "engine/core/file_io.h"
#include "tests/support/documents.h"

namespace airclay {
namespace {

namespace fs = std::filesystem;

void expectRefused(const fs::path& file, const std::string& expected) {
  expectOneLine(messageOf([&] { Document::open(file); }), file, expected);
}

TEST(DocumentFaults, RejectsOtherFiles) {
  const TemporaryFolder folder;
  expectRefused(folder / "none.clay", "there is no such file");
  expectRefused(folder.path(), "is not a file");
  expectRefused(folder.write("empty.clay", ""), "truncated to 0 bytes");
  expectRefused(folder.write("text.clay", std::string(5000, 'x')), "is not an Airclay document");
  expectRefused(folder.write("short.clay", "SQLite format 3"), "is not an Airclay document");
  alter(folder / "other.clay", "CREATE TABLE song (name TEXT); INSERT INTO song VALUES ('la')");
  const std::string before = readWhole(folder / "other.clay", kMaxDocumentBytes);
  expectRefused(folder / "other.clay", "another program's database");
  EXPECT_EQ(readWhole(folder / "other.clay", kMaxDocumentBytes), before);
  ASSERT_EQ(mkfifo((folder / "pipe.clay").c_str(), 0600), 0);
  expectRefused(folder / "pipe.clay", "is not a file");
}

TEST(DocumentFaults, RejectsNewerFormatWithoutChangingIt) {
  const TemporaryFolder folder;
  Document::create(folder / "a.clay", tubeState());
  alter(folder / "a.clay", "PRAGMA user_version = 2");
  const std::string before = readWhole(folder / "a.clay", kMaxDocumentBytes);
  expectRefused(folder / "a.clay", "was created by a newer Airclay (format 2; this version reads 1)");
  EXPECT_EQ(readWhole(folder / "a.clay", kMaxDocumentBytes), before);
}

TEST(DocumentFaults, RejectsTruncatedFiles) {
  const TemporaryFolder folder;
  const std::string whole = someDocument(folder);
  for (std::size_t size = 1; size < whole.size(); size += size < 1200 ? 97 : 1021) {
    SCOPED_TRACE(size);
    const fs::path file = folder.write("cut.clay", whole.substr(0, size));
    expectRefused(file, "truncated");
    EXPECT_EQ(readWhole(file, kMaxDocumentBytes).size(), size);
  }
}

// For any bytes: an error or valid clay.
TEST(DocumentFaults, DamagedBytesNeverCrash) {
  const TemporaryFolder folder;
  const std::string whole = someDocument(folder);
  std::mt19937 random(3);
  int refused = 0;
  for (int round = 0; round < 100; ++round) {
    std::string bytes = whole;
    const unsigned places = 1 + random() % 20;
    for (unsigned i = 0; i < places; ++i) bytes[random() % bytes.size()] = static_cast<char>(random());
    const fs::path file = folder.write("damaged.clay", bytes);
    const std::string message = messageOf([&] {
      Document document = Document::open(file);
      const ClayState state = document.state();
      EXPECT_NO_THROW(checkClayState(state, "damaged"));
      if (document.canRedo()) document.redo(document.redoCount());
      while (document.canUndo()) document.undo();
      document.commit("Push", afterStroke(document.state(), 1));
    });
    if (message.empty()) continue;
    ++refused;
    expectOneLine(message, file, "");
  }
  EXPECT_GT(refused, 25);
}

TEST(DocumentFaults, RejectsInvalidValuesInEveryColumn) {
  const TemporaryFolder folder;
  const std::string whole = someDocument(folder);
  const std::pair<const char*, const char*> edits[] = {
      {"UPDATE entry SET levels = 0", "level 0 must be 1 to 15"},
      {"UPDATE entry SET levels = 1 << 40", "must be 1 to 15"},
      {"UPDATE entry SET rule = 'loop'", "unknown rule; expected catmull-clark or printed"},
      {"UPDATE entry SET solve = 'none'", "unknown solve; expected all or touched"},
      {"UPDATE entry SET name = ''", "a name's length"},
      {"UPDATE entry SET points = zeroblob(24)", "24 bytes of control points; expected 672"},
      {"UPDATE entry SET points = zeroblob(120000000)", "120000000 bytes of control points"},
      {"UPDATE entry SET points = substr(points, 1, 671)", "671 bytes of control points"},
      {"UPDATE entry SET connectivity = 99", "connectivity 99 is missing"},
      {"UPDATE connectivity SET point_count = 27", "expected 648"},
      {"UPDATE connectivity SET point_count = 0", "a cage of 0 points"},
      {"UPDATE connectivity SET point_count = 1 << 50", "a cage of 1125899906842624 points"},
      {"UPDATE connectivity SET faces = x''", "needs points and faces"},
      {"UPDATE connectivity SET faces = x'0300000000'", "faces of 5 bytes"},
      {"UPDATE connectivity SET faces = x'02000000'", "a face of 2 corners"},
      {"UPDATE connectivity SET faces = x'ffffff7f00000000'", "a face of 2147483647 corners"},
      {"UPDATE connectivity SET faces = x'03000000000000000100000063000000'", "out of range"},
      {"UPDATE document SET current_entry = 99", "the current entry is missing"},
      {"DELETE FROM document", "something is missing"},
      {"DELETE FROM entry", "the current entry is missing"},
      {"DELETE FROM connectivity", "is missing"},
      {"DROP TABLE entry", "no such table"},
      {"ALTER TABLE entry RENAME TO e; CREATE VIEW entry AS SELECT * FROM e", "entry"},
      {"ALTER TABLE entry RENAME TO e; CREATE TABLE entry AS SELECT * FROM e; UPDATE entry SET points = 5",
       "column points has the wrong type"},
      {"UPDATE entry SET id = 9223372036854775807 WHERE id = 8", "an entry's number"},
      {"PRAGMA user_version = 0", "its format is 0"},
      {"ALTER TABLE entry ADD COLUMN turn BLOB; UPDATE entry SET turn = zeroblob(24)", "3 numbers"},
      {"ALTER TABLE entry ADD COLUMN turn BLOB; UPDATE entry SET turn = zeroblob(32)", "a unit quaternion"},
      {"ALTER TABLE entry RENAME TO e; CREATE TABLE entry AS SELECT *, 5 AS turn FROM e",
       "column turn has the wrong type"},
  };
  for (const auto& [sql, expected] : edits) {
    SCOPED_TRACE(sql);
    const fs::path file = folder.write("edited.clay", whole);
    alter(file, sql);
    expectRefused(file, expected);
  }
  // An invalid coordinate: a double of all ones.
  const fs::path file = folder.write("nan.clay", whole);
  std::string hex;
  for (int i = 0; i < 672; ++i) hex += "ff";
  alter(file, "UPDATE entry SET points = x'" + hex + "'");
  expectRefused(file, "control point 1 is not finite");
}

TEST(DocumentFaults, UndoStopsAtADamagedEntry) {
  const TemporaryFolder folder;
  const fs::path file = folder.write("a.clay", someDocument(folder));
  alter(file, "UPDATE entry SET points = x'00' WHERE id = 3");
  Document document = Document::open(file);
  while (document.undoCount() > 3) document.undo();
  const ClayState state = document.state();
  expectOneLine(messageOf([&] { document.undo(); }), file, "entry 3 has 1 bytes of control points");
  EXPECT_TRUE(sameClay(document.state(), state));
  EXPECT_EQ(document.undoCount(), 3);
  document.undo(2);  // past it
  EXPECT_EQ(document.undoCount(), 1);
}

// Another tool may have switched it on: the document is one file again.
TEST(DocumentFaults, ReadsWriteAheadLog) {
  const TemporaryFolder folder;
  const fs::path file = folder.write("a.clay", someDocument(folder));
  alter(file, "PRAGMA journal_mode = WAL; UPDATE entry SET name = 'Logged' WHERE id = 1");
  {
    Document document = Document::open(file);
    EXPECT_EQ(document.history()[0].name, "Logged");
    document.commit("Push", afterStroke(document.state(), 1));
    EXPECT_FALSE(fs::exists(folder / "a.clay-wal"));
  }
  EXPECT_EQ(rowsOf(file, "PRAGMA journal_mode")[0][0], "delete");
}

// A trigger is a program inside the file.
TEST(DocumentFaults, RunsNoTriggers) {
  const TemporaryFolder folder;
  const fs::path file = folder.write("a.clay", someDocument(folder));
  alter(file, "CREATE TRIGGER t AFTER UPDATE ON document BEGIN DELETE FROM entry; END");
  Document::open(file).undo();
  EXPECT_EQ(Document::open(file).history().size(), 8u);
}

int page_limit = 0;

/// SQLite calls this for every connection.
int limitPages(sqlite3* connection, const char**, const sqlite3_api_routines*) {
  return sqlite3_exec(connection, ("PRAGMA max_page_count = " + std::to_string(page_limit)).c_str(), nullptr,
                      nullptr, nullptr);
}

/// While it exists, files that are opened cannot grow past this number of pages: SQLITE_FULL, as on a full
/// disk.
struct FullDisk {
  explicit FullDisk(int pages) {
    page_limit = pages;
    sqlite3_auto_extension(reinterpret_cast<void (*)()>(limitPages));
  }
  ~FullDisk() { sqlite3_reset_auto_extension(); }
};

TEST(DocumentFaults, FullDiskLosesNoData) {
  const TemporaryFolder folder;
  const fs::path file = folder.write("a.clay", someDocument(folder));
  const int pages = std::stoi(rowsOf(file, "SELECT page_count FROM pragma_page_count")[0][0]);
  ClayState state;
  {
    const FullDisk full(pages + 2);
    Document document = Document::open(file);
    std::string message;
    int edits = document.undoCount();
    for (int i = 0; message.empty() && i < 50; ++i) {
      state = document.state();
      message = messageOf([&] { document.commit("Push", afterStroke(largeState(), 100 + i)); });
      if (message.empty()) ++edits;
    }
    expectOneLine(message, file, "the disk is full, so nothing was written; free some space");
    EXPECT_TRUE(sameClay(document.state(), state));
    EXPECT_EQ(document.undoCount(), edits);
    document.undo();  // needs no space
    document.redo();
  }
  Document document = Document::open(file);
  EXPECT_TRUE(sameClay(document.state(), state));
  document.commit("Push", afterStroke(largeState(), 200));  // there is space again
  EXPECT_TRUE(sameClay(document.state(), afterStroke(largeState(), 200)));

  const FullDisk full(3);
  expectOneLine(messageOf([&] { Document::create(folder / "b.clay", largeState()); }), folder / "b.clay",
                "the disk is full");
  EXPECT_FALSE(fs::exists(folder / "b.clay"));
}

TEST(DocumentFaults, FileSizeLimitLosesNoData) {
  const TemporaryFolder folder;
  const fs::path file = folder.write("a.clay", someDocument(folder));
  Document document = Document::open(file);
  const ClayState state = document.state();
  const std::vector<std::string> names = namesOf(document);
  signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  rlimit limit = before;
  limit.rlim_cur = fs::file_size(file) + 8192;
  setrlimit(RLIMIT_FSIZE, &limit);
  const std::string message = messageOf([&] { document.commit("Push", afterStroke(largeState(), 1)); });
  const std::string copy_message = messageOf([&] { document.saveAs(folder / "b.clay"); });
  limit.rlim_cur = 8192;
  setrlimit(RLIMIT_FSIZE, &limit);
  const std::string small_message = messageOf([&] { document.saveAs(folder / "c.clay"); });
  setrlimit(RLIMIT_FSIZE, &before);
  expectOneLine(message, file, "cannot be read or written: ");
  EXPECT_EQ(copy_message, "");
  expectOneLine(small_message, folder / "c.clay", "cannot be read or written: File too large");
  EXPECT_FALSE(fs::exists(folder / "c.clay"));
  EXPECT_TRUE(sameClay(document.state(), state));
  EXPECT_EQ(namesOf(document), names);
  document.commit("Push", afterStroke(largeState(), 1));
  document.undo();
  EXPECT_TRUE(sameClay(document.state(), state));
}

/// While it exists, file permissions apply to this process, even as root.
struct AsNobody {
  AsNobody() { is_root = geteuid() == 0 && seteuid(65534) == 0; }
  ~AsNobody() {
    if (is_root && seteuid(0) != 0) ADD_FAILURE() << "root is lost";
  }
  bool is_root = false;
};

TEST(DocumentFaults, OpenReportsReadOnlyFileOrFolder) {
  const TemporaryFolder folder;
  const fs::path file = folder.write("in/a.clay", someDocument(folder));
  fs::permissions(folder.path(), fs::perms(0755));
  const auto refuses = [&](unsigned file_rights, unsigned folder_rights, const std::string& expected) {
    fs::permissions(file, fs::perms(file_rights));
    fs::permissions(file.parent_path(), fs::perms(folder_rights));
    std::string message, new_message;
    {
      const AsNobody nobody;
      message = messageOf([&] { Document::open(file); });
      new_message = messageOf([&] { Document::create(file.parent_path() / "b.clay", tubeState()); });
    }
    expectOneLine(message, file, expected);
    if (folder_rights == 0555)
      expectOneLine(new_message, file.parent_path() / "b.clay",
                    "Permission denied; use a file in a writable folder");
    fs::permissions(file.parent_path(), fs::perms(0755));
    fs::remove(file.parent_path() / "b.clay");
  };
  refuses(0444, 0777, "is write-protected; use a copy");
  refuses(0666, 0555, "its folder cannot be written (Permission denied)");
  refuses(0000, 0777, "cannot be opened: Permission denied");
  fs::permissions(file, fs::perms(0644));
  EXPECT_EQ(Document::open(file).history().size(), 8u);
}

TEST(DocumentFaults, FolderThatBecomesReadOnlyLosesNoData) {
  const TemporaryFolder folder;
  const fs::path file = folder.write("in/a.clay", someDocument(folder));
  fs::permissions(folder.path(), fs::perms(0755));
  fs::permissions(file, fs::perms(0666));
  fs::permissions(file.parent_path(), fs::perms(0777));
  Document document = Document::open(file);
  const ClayState state = document.state();
  fs::permissions(file.parent_path(), fs::perms(0555));
  {
    const AsNobody nobody;
    expectOneLine(messageOf([&] { document.commit("Push", afterStroke(state, 1)); }), file,
                  "cannot be written: its folder is write-protected");
    EXPECT_TRUE(sameClay(document.state(), state));
  }
  fs::permissions(file.parent_path(), fs::perms(0755));
  document.commit("Push", afterStroke(state, 1));
  EXPECT_TRUE(sameClay(document.state(), afterStroke(state, 1)));
}

}  // namespace
}  // namespace airclay
