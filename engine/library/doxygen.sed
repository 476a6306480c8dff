# Comments of the headers as Doxygen reads them: the head of a file, lines before a declaration, words behind one.
1s|^// \([a-z_]*\.h\) - |/// @file\n/// |
s|@\([a-z]*\.\)|\\@\1|g
s|^\( *\)// |\1/// |
s|^\( *\)//$|\1///|
s|^\( *[^ /].*[;,{)] *\)// |\1///< |
