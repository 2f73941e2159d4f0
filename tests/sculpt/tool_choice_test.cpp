// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <set>

#include "engine/sculpt/tools.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

TEST(ToolChoice, ToolsAreRegisteredOnceAndComplete) {
  std::set<std::string> ids, names;
  for (const Tool* tool : tools()) {
    EXPECT_TRUE(ids.insert(tool->id).second) << tool->id;
    EXPECT_TRUE(names.insert(tool->name).second) << tool->name;
    EXPECT_EQ(findTool(tool->id), tool);
    EXPECT_NE(std::string(tool->description), "");
    EXPECT_NE(std::string(tool->icon), "");
    EXPECT_NE(tool->create, nullptr);
    for (const ToolSetting& setting : tool->settings) {
      EXPECT_LE(setting.minimum, setting.initial) << setting.id;
      EXPECT_LE(setting.initial, setting.maximum) << setting.id;
    }
  }
  EXPECT_EQ(findTool("hammer"), nullptr);
  EXPECT_EQ(toolIds(), "push, pull or smooth");
}

TEST(ToolChoice, TextAndChoiceConvertBothWays) {
  EXPECT_EQ(formatTool(ToolChoice(*findTool("pull"))), "pull");
  EXPECT_EQ(formatTool(parseTool("pull:reach=12")), "pull:reach=12");
  EXPECT_EQ(formatTool(parseTool("smooth:reach=8,strength=0.5")), "smooth:reach=8,strength=0.5");
  // omits a value that equals the initial one
  const Tool& pull = *findTool("pull");
  ToolChoice choice(pull);
  choice.setValue(0, pull.settings[0].initial);
  EXPECT_EQ(formatTool(choice), "pull");
  // keeps every digit
  choice.setValue(0, 12.345678901234567);
  EXPECT_EQ(parseTool(formatTool(choice)), choice);
}

TEST(ToolChoice, ValuesAreClampedToTheSettingsRange) {
  const Tool& pull = *findTool("pull");
  ToolChoice choice(pull);
  choice.setValue(0, 1e6);
  EXPECT_EQ(choice.values()[0], pull.settings[0].maximum);
  choice.setValue(0, -1e6);
  EXPECT_EQ(choice.values()[0], pull.settings[0].minimum);
}

TEST(ToolChoice, ErrorsNameTheTextAndWhatWouldBeRight) {
  const auto message = [](const char* text) { return messageOf([&] { parseTool(text); }); };
  EXPECT_NE(message("hammer").find("push, pull"), std::string::npos) << message("hammer");
  EXPECT_NE(message("pull:depth=3").find("depth"), std::string::npos) << message("pull:depth=3");
  EXPECT_NE(message("pull:reach=far").find("far"), std::string::npos) << message("pull:reach=far");
  EXPECT_NE(message("pull:reach=1000").find("40"), std::string::npos) << message("pull:reach=1000");
  EXPECT_NE(message("push:reach=3").find("reach"), std::string::npos) << message("push:reach=3");
  for (const char* text : {"", ":", "pull:", "pull:reach", "pull:reach=", "pull:reach=nan", "pull:,"})
    EXPECT_NE(message(text), "") << text;
}

}  // namespace
}  // namespace airclay
