#pragma once
/*
  A law of a plugin in place of those of the build.
*/

/* Makes the plugin's law of this name the one under test; 0, or 2 after a line on stderr. */
int LawPluginUse(const char path[], const char name[]);
