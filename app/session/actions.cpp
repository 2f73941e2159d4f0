// SPDX-License-Identifier: MIT
#include "app/session/actions.h"

#include <sstream>

#include "engine/core/error.h"
#include "engine/core/file_io.h"

namespace airclay {
namespace {

using Kind = Action::Kind;

// 400 bytes per frame with the mouse hand: six hours at 60 Hz take half of this.
constexpr std::size_t kMostBytes = std::size_t(1) << 30;
constexpr int kFormat = 1;

constexpr const char* kRules[] = {"catmull-clark", "printed"};
// In the order of Action::Kind.
constexpr const char* kActionNames[] = {"stroke", "undo",     "redo",  "refine", "form",  "turn",
                                        "clay",   "document", "again", "empty",  "remesh"};

std::string wordOf(const Symmetry& symmetry) {
  const std::string axes =
      std::string(symmetry.x ? "x" : "") + (symmetry.y ? "y" : "") + (symmetry.z ? "z" : "");
  return axes.empty() ? "-" : axes;
}

/// Reads the fields of one line from the left.
class Line {
 public:
  Line(const std::string& where, std::string_view text) : where_(where), words_(std::string(text)) {}

  [[noreturn]] void fail(const std::string& expected) const { reject("expected " + expected); }
  [[noreturn]] void reject(const std::string& message) const { throw Error(where_ + ": " + message); }
  /// Empty after the last field.
  std::string word() {
    std::string word;
    words_ >> word;
    return word;
  }
  /// The rest of the line.
  std::string rest() {
    std::string text;
    std::getline(words_ >> std::ws, text);
    return text;
  }
  double number(const std::string& expected) {
    const std::optional<double> value = parseNumber(word());
    if (!value) fail(expected);
    return *value;
  }
  int whole(int low, int high, const std::string& expected) {
    const double value = number(expected);
    if (value < low || value > high || value != static_cast<int>(value)) fail(expected);
    return static_cast<int>(value);
  }
  template <std::size_t n>
  int oneOf(const char* const (&words)[n], const std::string& expected) {
    const std::string found = word();
    for (std::size_t i = 0; i < n; ++i)
      if (found == words[i]) return static_cast<int>(i);
    fail(expected);
  }
  /// A file in the same folder: a name without a path.
  std::string fileBeside() {
    const std::string name = word();
    if (name.empty() || name.find('/') != std::string::npos || name.starts_with("."))
      fail("the name of a file in the same folder");
    return name;
  }
  void end() {
    if (!word().empty()) fail("nothing after this line's last value");
  }

 private:
  const std::string& where_;
  std::istringstream words_;
};

Symmetry readSymmetry(Line& line) {
  Symmetry symmetry;
  for (const char axis : line.word()) {
    if (axis != '-' && axis != 'x' && axis != 'y' && axis != 'z') line.fail("a symmetry: x, y, z or -");
    symmetry.x |= axis == 'x';
    symmetry.y |= axis == 'y';
    symmetry.z |= axis == 'z';
  }
  return symmetry;
}

std::vector<HandPose> readHands(Line& line) {
  std::string word = line.word();
  if (word == "nobody") return {};
  std::vector<HandPose> hands;
  do {
    if (!hands.empty()) word = line.word();  // after `and`
    HandPose& pose = hands.emplace_back();
    for (int i = 0; i < 12; ++i, word = line.word()) {
      const std::optional<double> value = parseNumber(word);
      if (!value) line.fail("12 numbers for the hand, or `nobody`");
      pose.world_from_hand.matrix()(i / 4, i % 4) = *value;
    }
    if (word == "joints") {
      pose.joint_angles.resize(std::size_t(line.whole(1, kMaxHandJoints, "the number of joints")));
      for (Vec3& angles : pose.joint_angles)
        for (double& angle : angles) angle = line.number("a joint angle in radians");
      word = line.word();
    }
  } while (word == "and" && hands.size() < kMaxHands);
  if (!word.empty()) line.fail("`joints`, `and` and a second hand, or nothing more");
  return hands;
}

ToolChoice readTool(Line& line) {
  const std::string text = line.word();
  if (!findTool(text.substr(0, text.find(':')))) line.fail(toolIds());
  try {
    return parseTool(text);
  } catch (const Error& error) {
    line.reject(error.what());
  }
}

ReplayFrame readFrame(Line& line, bool by_mouse) {
  ReplayFrame frame;
  frame.time_s = line.number("the frame's time in seconds");
  frame.step_s = line.number("the seconds since the last frame");
  frame.tool = readTool(line);
  frame.symmetry = readSymmetry(line);
  frame.held = line.whole(0, 1, "0 or 1 for the clutch") == 1;
  frame.filtered = line.whole(0, 1, "0 or 1 for the filter") == 1;
  if (by_mouse) frame.given_hands = readHands(line);
  const std::string more = by_mouse ? "" : line.word();
  if (more == "without")
    frame.missing_cameras = static_cast<std::uint32_t>(line.number("the missing cameras' bits"));
  else if (!more.empty())
    line.fail("`without` and bits, or nothing more");
  line.end();
  return frame;
}

std::optional<Action> readAction(const std::string& word, Line& line) {
  Action action;
  int what = -1;
  for (int i = 0; i < static_cast<int>(std::size(kActionNames)); ++i)
    if (word == kActionNames[i]) what = i;
  if (what < 0) return std::nullopt;
  action.kind = static_cast<Kind>(what);
  if (action.kind == Kind::kSurface) {
    action.levels = line.whole(1, kMaxStateLevels, "a level from 1 to " + std::to_string(kMaxStateLevels));
    action.rule = static_cast<SubdivisionRule>(line.oneOf(kRules, "catmull-clark or printed"));
    action.solve = findSolveMethod(line.word());
    if (!action.solve) line.fail(solveMethodIds());
  } else if (action.kind == Kind::kRemesh) {
    action.faces = line.whole(1, 1'000'000, "how many faces");
  } else if (action.kind == Kind::kTurn) {
    for (double& value : action.axis) value = line.number("the axis x y z");
    action.angle_rad = line.number("the angle in radians");
    action.last = line.oneOf({"more", "last"}, "more or last") == 1;
  } else if (action.kind == Kind::kClay || action.kind == Kind::kDocument) {
    action.file = line.fileBeside();
    action.name = line.rest();
  }
  line.end();
  return action;
}

class ActionsReader {
 public:
  explicit ActionsReader(const std::filesystem::path& file) : file_(file.string()) {
    const std::string text = readWhole(file, kMostBytes);
    std::size_t at = 0;
    for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', at)) {
      where_ = file_ + ":" + std::to_string(++number_);
      take(std::string_view(text).substr(at, end - at));
      at = end + 1;
    }
    if (number_ == 0) throw Error(file_ + ": it is empty; expected `airclay-actions 1` in the first line");
  }

  Actions actions;

 private:
  void take(std::string_view text) {
    Line line(where_, text);
    const std::string word = line.word();
    if (number_ == 1) return takeFormat(word, line);
    if (word.empty() || word.starts_with("#")) return;
    if (actions.ended) line.fail("nothing after `end`");
    if (takeHead(word, line)) return;
    if (word == "learn" || word == "frame") {
      Actions::Step step{std::move(actions.after), {}};
      actions.after.clear();
      if (word == "frame") step.frame = readFrame(line, actions.head.by_mouse);
      step.frame.learned = word == "learn";
      actions.steps.push_back(std::move(step));
    } else if (word == "end") {
      actions.ended = true;
    } else if (const std::optional<Action> action = readAction(word, line)) {
      actions.after.push_back(*action);
    } else {
      throw Error(where_ + ": '" + printable(word) + "' is not an action");
    }
  }

  void takeFormat(const std::string& word, Line& line) {
    if (word != "airclay-actions") line.fail("`airclay-actions 1` in the first line");
    if (line.number("the format's number") > kFormat)
      throw Error(where_ +
                  ": these actions were recorded by a newer Airclay; use that version to replay them");
  }

  bool takeHead(const std::string& word, Line& line) {
    if (word == "background")
      actions.head.background_frames = line.whole(0, 1'000'000, "how many frames");
    else if (word == "voxels")
      actions.head.voxels = line.whole(1, 4096, "voxels along the workspace's edge");
    else if (word == "hand")
      actions.head.hand = line.fileBeside();
    else if (word == "mouse")
      actions.head.by_mouse = true;
    else
      return false;
    line.end();
    return true;
  }

  std::string file_, where_;
  int number_ = 0;
};

}  // namespace

std::string linesOf(const ActionsHeader& head) {
  return "airclay-actions " + std::to_string(kFormat) + "\nbackground " +
         std::to_string(head.background_frames) + "\nvoxels " + std::to_string(head.voxels) + "\nhand " +
         head.hand + "\n" + (head.by_mouse ? "mouse\n" : "");
}

std::string lineOf(const Action& action) {
  std::string line = kActionNames[static_cast<int>(action.kind)];
  switch (action.kind) {
    case Kind::kSurface:
      line += " " + std::to_string(action.levels) + " " + kRules[static_cast<int>(action.rule)] + " " +
              action.solve->id;
      break;
    case Kind::kRemesh:
      line += " " + std::to_string(action.faces);
      break;
    case Kind::kTurn:
      for (const double value : action.axis) line += " " + exactNumber(value);
      line += " " + exactNumber(action.angle_rad) + (action.last ? " last" : " more");
      break;
    case Kind::kClay:
      line += " " + action.file + " " + action.name;
      break;
    case Kind::kDocument:
      line += " " + action.file;
      break;
    default:
      break;
  }
  return line + "\n";
}

std::string lineOf(const ReplayFrame& frame, bool by_mouse) {
  if (frame.learned) return "learn\n";
  std::string line = "frame " + exactNumber(frame.time_s) + " " + exactNumber(frame.step_s) + " " +
                     formatTool(frame.tool) + " " + wordOf(frame.symmetry) + (frame.held ? " 1" : " 0") +
                     (frame.filtered ? " 1" : " 0");
  if (frame.missing_cameras != 0) line += " without " + std::to_string(frame.missing_cameras);
  if (by_mouse && frame.given_hands.empty()) line += " nobody";
  for (std::size_t k = 0; k < frame.given_hands.size(); ++k) {
    const HandPose& pose = frame.given_hands[k];
    if (k > 0) line += " and";
    for (int i = 0; i < 12; ++i) line += " " + exactNumber(pose.world_from_hand.matrix()(i / 4, i % 4));
    if (pose.joint_angles.empty()) continue;
    line += " joints " + std::to_string(pose.joint_angles.size());
    for (const Vec3& angles : pose.joint_angles)
      for (const double angle : angles) line += " " + exactNumber(angle);
  }
  return line + "\n";
}

bool hasActions(const std::filesystem::path& folder) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(folder / kActionsFile, ignored);
}

Actions readActions(const std::filesystem::path& file) {
  return ActionsReader(file).actions;
}

}  // namespace airclay
