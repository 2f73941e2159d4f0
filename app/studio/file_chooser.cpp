// SPDX-License-Identifier: MIT
#include "app/studio/file_chooser.h"

#include <imgui/imgui.h>
#include <imgui/imgui_stdlib.h>

#include <algorithm>

#include "app/studio/theme.h"

namespace airclay {
namespace {

constexpr std::size_t kMostListed = 5000;  // a folder with more is shown in part; a name can be typed

}  // namespace

void FileChooser::open(const std::string& title, const std::filesystem::path& folder,
                       std::vector<std::string> endings, bool to_write, Chosen chosen) {
  title_ = title;
  endings_ = std::move(endings);
  to_write_ = to_write;
  chosen_ = std::move(chosen);
  name_.clear();
  open_ = true;
  asked_ = false;
  std::error_code fault;
  goTo(std::filesystem::is_directory(folder, fault) ? folder : std::filesystem::current_path(fault));
}

void FileChooser::goTo(const std::filesystem::path& folder) {
  std::error_code fault;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(folder, fault);
  std::vector<Listed> listed;
  for (std::filesystem::directory_iterator at(whole, fault), end; !fault && at != end; at.increment(fault)) {
    const std::string name = at->path().filename().string();
    std::error_code ignored;
    const bool is_folder = at->is_directory(ignored);
    const bool wanted =
        is_folder || std::find(endings_.begin(), endings_.end(), at->path().extension()) != endings_.end();
    if (!name.starts_with(".") && wanted) listed.push_back({name, is_folder});
    if (listed.size() == kMostListed) break;
  }
  if (fault) {
    fault_ = whole.string() + ": " + fault.message();
    return;
  }
  std::sort(listed.begin(), listed.end(), [](const Listed& a, const Listed& b) {
    return a.is_folder != b.is_folder ? a.is_folder : a.name < b.name;
  });
  listed_ = std::move(listed);
  folder_ = whole;
  fault_.clear();
}

bool FileChooser::accept() {
  if (name_.empty()) return false;
  std::filesystem::path file =
      std::filesystem::path(name_).is_absolute() ? std::filesystem::path(name_) : folder_ / name_;
  std::error_code fault;
  if (std::filesystem::is_directory(file, fault)) {
    goTo(file);
    name_.clear();
    return false;
  }
  if (to_write_ && file.extension().empty()) file += endings_.front();
  if (!to_write_ && !std::filesystem::exists(file, fault)) {
    fault_ = "there is no " + file.string();
    return false;
  }
  chosen_(file);
  return true;
}

void FileChooser::drawList() {
  ImGui::BeginChild("files", ImVec2(ImGui::GetFontSize() * 30, ImGui::GetFontSize() * 16), true);
  std::filesystem::path next;
  if (ImGui::Selectable("..  the folder above")) next = folder_.parent_path();
  for (const Listed& one : listed_) {
    if (one.is_folder) {
      if (ImGui::Selectable((one.name + "/").c_str())) next = folder_ / one.name;
    } else if (ImGui::Selectable(one.name.c_str(), one.name == name_)) {
      name_ = one.name;
    }
  }
  ImGui::EndChild();
  if (!next.empty()) goTo(next);
}

void FileChooser::draw() {
  if (!open_) return;
  if (!asked_) ImGui::OpenPopup(title_.c_str());
  asked_ = true;
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(size.x / 2, size.y / 2), ImGuiCond_Always, ImVec2(0.5f, 0.5f));
  if (!ImGui::BeginPopupModal(title_.c_str(), nullptr, ImGuiWindowFlags_AlwaysAutoResize)) {
    open_ = false;
    return;
  }
  ImGui::TextDisabled("%s", folder_.c_str());
  drawList();
  if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
  ImGui::SetNextItemWidth(ImGui::GetFontSize() * 30);
  const bool entered =
      ImGui::InputTextWithHint("##name", "name", &name_, ImGuiInputTextFlags_EnterReturnsTrue);
  if (!fault_.empty()) ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(look::kBad), "%s", fault_.c_str());
  bool done = false;
  if (ImGui::Button(to_write_ ? "Write" : "Open") || entered) done = accept();
  ImGui::SameLine();
  if (ImGui::Button("Cancel") || ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false)) done = true;
  if (done) {
    ImGui::CloseCurrentPopup();
    open_ = false;
  }
  ImGui::EndPopup();
}

}  // namespace airclay
