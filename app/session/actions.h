// SPDX-License-Identifier: MIT
// actions.txt in a recorded take: the user's actions, frame by frame. Replaying it on the frames and
// start.clay, the initial clay, gives the same clay.
//
// Each line is a keyword and its values, separated by spaces; numbers have full precision.
//
//     airclay-actions 1                 the format
//     background N                      how many first frames may show the empty workspace
//     voxels N                          along the workspace's edge
//     hand right|left|FILE              FILE lies beside
//     mouse                             there are no cameras: every frame says where the hand is
//     learn                             a frame that taught the empty workspace
//     frame TIME STEP TOOL AXES HELD STEADY
//                                       a frame: seconds of the recording, seconds since the last frame, push
//                                       pull or smooth with the settings that were changed, as
//                                       `pull:reach=12`, the symmetry (xyz or -), 1 while the clutch lets the
//                                       hand shape the clay, 1 with the One Euro filter; then `without BITS`
//                                       where cameras were missing, bit k the k-th; or, of the mouse's hand,
//                                       12 numbers: world_from_hand, three rows of four; then, of a hand that
//                                       is not in the rest pose, `joints N` and 3 N numbers:
//                                       HandPose::joint_angles; a second hand follows after `and`; or
//                                       `nobody`
//     stroke                            the stroke under way ended here
//     undo | redo | refine | again      again: the source began anew, the hand is looked for
//     empty                             the empty workspace is forgotten; frames that teach it anew follow
//     form LEVEL RULE SOLVE
//     remesh FACES                      the cage became one of about so many faces for the same surface
//     turn X Y Z RADIANS more|last      clay and planes of symmetry, about an axis through the
//                                       workspace's centre
//     clay FILE NAME                    the clay became that of FILE; NAME is the entry's
//     document FILE                     another document was opened; FILE is its copy
//     end                               the recording was ended; without it, it broke off
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/clay/clay_state.h"
#include "engine/core/math.h"
#include "engine/hand/hand_pose.h"
#include "engine/sculpt/tools.h"

namespace airclay {

/// One action between two frames.
struct Action {
  enum class Kind {
    kEndStroke,
    kUndo,
    kRedo,
    kRefine,
    kSurface,
    kTurn,
    kClay,
    kDocument,
    kRestart,
    kEmpty,
    kRemesh
  };
  Kind kind = Kind::kUndo;
  int levels = 2;  ///< kSurface
  SubdivisionRule rule = SubdivisionRule::kCatmullClark;
  const SolveMethod* solve = &kSolveAll;
  int faces = 0;              ///< kRemesh
  Vec3 axis = Vec3::UnitZ();  ///< kTurn: about the workspace's centre
  double angle_rad = 0;
  bool last = false;       ///< kTurn: the rotation ends
  std::string file, name;  ///< kClay, kDocument
};

/// A frame as it was processed.
struct ReplayFrame {
  bool learned = false;  ///< learned the background; the other members do not apply
  double time_s = 0, step_s = 0;
  ToolChoice tool;
  Symmetry symmetry;
  bool held = true, filtered = true;
  std::uint32_t missing_cameras = 0;  ///< bit mask of cameras without an image
  std::vector<HandPose> given_hands;  ///< of the mouse hand; empty without one
};

/// The recording's settings.
struct ActionsHeader {
  int background_frames = 0, voxels = 128;
  std::string hand = "right";  ///< right, left, or a file in the same folder
  bool by_mouse = false;
};

struct Actions {
  struct Step {
    std::vector<Action> before;
    ReplayFrame frame;
  };
  ActionsHeader head;
  std::vector<Step> steps;    ///< one per frame
  std::vector<Action> after;  ///< the last frame
  bool ended = false;         ///< false: the recording is incomplete
};

std::string linesOf(const ActionsHeader& head);
std::string lineOf(const Action& action);
std::string lineOf(const ReplayFrame& frame, bool by_mouse);
inline constexpr const char* kActionsFile = "actions.txt";
inline constexpr const char* kActionsEnd = "end\n";
inline constexpr const char* kStartFile = "start.clay";

/// Whether the folder contains recorded actions.
bool hasActions(const std::filesystem::path& folder);

/// Ignores a last line without a newline. \throw Error naming file and line.
Actions readActions(const std::filesystem::path& file);

}  // namespace airclay
