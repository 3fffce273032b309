"""How human the motion is: measured reaches predicted from start, target and duration alone, and scored."""
