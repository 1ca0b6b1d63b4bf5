"""What each file format is asked before a library reads it.

trimesh reads the numbers; these modules make sure that it cannot misread them. Each holds one
function ``prepare(data) -> Prepared``: it compares what the header promises with what the file
holds, before memory is taken, and hands over bytes from which trimesh keeps the numbering.
"""
